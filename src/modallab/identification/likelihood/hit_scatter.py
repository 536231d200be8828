"""By how much the poles differ from hit to hit beyond what the noise explains.

The fit's covariance is that of noise. Where the structure itself changes a little from hit to hit, as with the
temperature or a clamp that settles, each hit pulls the poles its own way by more than that. What a hit pulls is its
part of the projected score, times the covariance; the sum of the squares of all pulls is the covariance that holds,
whatever the reason (the sandwich estimate, clustered by hits). Hits of which each knows its share w of a parameter pull
by covariances diag(w) - w w^T under noise alone, which gives the sum's mean and its degrees of freedom.

A shift of a frequency is felt by all outputs at once, what misfits the damping by each in its own way: hits beside
their points change the compliance there, and leave a residual that is uneven over lines, hits and outputs. There the
damping goes by what each output of each hit pulls, of which there are enough to know it well, and by how much wider
than they are resonances seem that stand elsewhere in every hit.
Sources: White, "Maximum likelihood estimation of misspecified models", Econometrica 50 (1982); Cameron and Miller, "A
practitioner's guide to cluster-robust inference", Journal of Human Resources 50 (2015); Satterthwaite, Biometrics
Bulletin 2 (1946).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri, ndtri, stdtrit

from modallab.core.arrays import Real
from modallab.identification.likelihood.even_residual import is_even
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.projection import InputSolution

LEAST_FREEDOM = 2.5
"""Degrees of freedom below which hits say nothing of their scatter: four that are alike have three."""
LEAST_HITS = 4
"""Fewer do not tell a shift of all outputs from what each misfits by itself."""
STEPS = 400
"""Times over a block."""
CHANCE = 0.001
"""Noise alone lets the scatter count for a mode's frequency, or its damping, no more often than this."""


def factors_by_scatter(fit: LikelihoodFit, misfit: float) -> Real:
    """(modes, 2) factors of the sigmas of omega and zeta, 1 where the hits scatter as the noise does.

    The fit takes its residual for noise. Where that is larger than the noise before the hits, the sigmas are too large
    for whatever the misfit does not touch: there the scatter counts between the two. Above, it counts where chance
    would hardly have it. Of few hits the scatter is known roughly, which Student's factor allows for. Where the
    residual is no even noise, zeta goes by the outputs of all hits, unless the hits disagree by more than these say.

    Args:
        fit: of the hits.
        misfit: the residual over the noise before the hits; NaN where that is not known.
    """
    scores, known = _pulls_by_output(fit)
    hits = _scatter_of_clusters(fit, influence_of_scores(fit, scores).sum(axis=2), known.sum(axis=2))
    least = 1 / max(1.0, misfit) if np.isfinite(misfit) else 1.0
    found = np.where(hits.far(1.0), hits.factor, np.clip(hits.factor, least, 1.0))
    found = np.where(hits.enough, found, 1.0).reshape(-1, 2)
    if len(scores) >= LEAST_HITS and not is_even(fit):
        stated = np.sqrt(np.diag(fit.refined.covariance.poles)[1::2])
        found[:, 1] = np.hypot(_factors_of_outputs(fit, scores, known, hits)[1::2], damping_bias(fit) / stated)
    return found


def damping_bias(fit: LikelihoodFit) -> Real:
    """(modes,) by how much zeta comes out too large at most, since the frequencies of the hits differ.

    Errors of the force that a fit also searches take up a part.
    """
    pulls, shares = hit_influences(fit)
    square = np.sum(pulls**2 / np.maximum(shares, np.finfo(float).tiny), axis=0)[::2]
    at, grid = fit.point.parameters, fit.problem.blocks[0].excitation.grid
    return np.asarray(square * decay_bias(at.omega * at.zeta, grid.n * grid.dt) / at.omega, np.float64)


def decay_bias(decay: Real, length_s: float) -> Real:
    """(modes,) s: by how much the mean of decays of a little scattered frequencies decays faster, over <d^2>.

    The mean of e^(-a t) e^(j d t) is e^(-a t) (1 - <d^2> t^2 / 2) to second order. With its amplitude free, that is a
    decay faster by <d^2> (t^2 / 2, t) / (t, t), both products weighted by e^(-2 a t) and without their mean: 1 / a in a
    block that is long, half the block's length in one that is short.
    """
    t = np.linspace(0.0, length_s, STEPS)
    weight = np.exp(-2 * np.outer(decay, t))
    weight /= weight.sum(axis=1, keepdims=True)
    off = t - (weight @ t)[:, None]
    return np.asarray(np.sum(weight * off * t**2 / 2, axis=1) / np.sum(weight * off * t, axis=1), np.float64)


def _factors_of_outputs(fit: LikelihoodFit, scores: Real, known: Real, hits: "_Scatter") -> Real:
    """(2 modes,) factors by what every output of every hit pulls, or by hits where these disagree by more.

    The errors of a hit's force, which all outputs feel, pull nothing in all: what outputs say of them is left out.
    """
    outputs = _scatter_of_clusters(fit, _sum_by_cluster(influence_of_scores(fit, scores)), _sum_by_cluster(known))
    together = np.where(hits.far(outputs.ratio), hits.factor, outputs.factor)
    return np.where(outputs.enough, together, 1.0)


def _sum_by_cluster(parts: Real) -> Real:
    """(clusters, 2 modes) of (hits, 2 modes, clusters of a hit)."""
    return np.moveaxis(parts, 2, 1).reshape(-1, parts.shape[1])


@dataclass(frozen=True, eq=False, slots=True)
class _Scatter:
    """Of each parameter: pulls' squares over what noise would make them, and degrees of freedom of that."""

    ratio: Real
    freedom: Real

    @property
    def enough(self) -> NDArray[np.bool_]:
        return self.freedom >= LEAST_FREEDOM

    @property
    def factor(self) -> Real:
        """Of the sigma, Student's with it."""
        return stdtrit(np.maximum(self.freedom, LEAST_FREEDOM), 0.975) / ndtri(0.975) * np.sqrt(self.ratio)

    def far(self, noise: float | Real) -> NDArray[np.bool_]:
        """Whether chance hardly lets noise of this square, over that of the fit, scatter so."""
        freedom = np.maximum(self.freedom, LEAST_FREEDOM)
        return self.enough & (self.ratio > noise * chdtri(freedom, CHANCE) / freedom)


def _scatter_of_clusters(fit: LikelihoodFit, pulls: Real, known: Real) -> _Scatter:
    """Of clusters (clusters, 2 modes), each with its pulls and what it knows."""
    shares = _shares_of_knowledge(known)
    square, cube = np.sum(shares**2, axis=0), np.sum(shares**3, axis=0)
    spare = np.maximum(1 - square, 1e-9)
    freedom = spare**2 / np.maximum(square - 2 * cube + square**2, 1e-12)
    stated = np.diag(fit.refined.covariance.poles)
    return _Scatter(np.sum(pulls**2, axis=0) / spare / np.maximum(stated, np.finfo(float).tiny), freedom)


def hit_influences(fit: LikelihoodFit) -> tuple[Real, Real]:
    """By how much each hit moves omega and zeta of every mode, and its share of what is known of them.

    Returns:
        (hits, 2 modes) pulls, which add up to about nothing; (hits, 2 modes) shares, which add up to 1.
    """
    scores, known = _pulls_by_output(fit)
    return influence_of_scores(fit, scores).sum(axis=2), _shares_of_knowledge(known.sum(axis=2))


def influence_of_scores(fit: LikelihoodFit, scores: Real) -> Real:
    """(hits, 2 modes, outputs) of scores of that shape."""
    return np.einsum("hpo,pq->hqo", scores, fit.refined.covariance.poles)


def _shares_of_knowledge(known: Real) -> Real:
    return known / np.maximum(known.sum(axis=0), np.finfo(float).tiny)


def _pulls_by_output(fit: LikelihoodFit) -> tuple[Real, Real]:
    """(hits, 2 modes, outputs) parts of the cost's derivative by the poles, and of the normal matrix's diagonal."""
    shape = (len(fit.problem.blocks), 2 * fit.point.parameters.omega.size, fit.point.noise.size)
    scores, known = np.zeros(shape), np.zeros(shape)
    for group in fit.point.groups:
        members = list(group.members)
        scores[members], known[members] = _scores_of_input(group, fit.point.noise)
    return scores, known


def _scores_of_input(group: InputSolution, noise: Real) -> tuple[Real, Real]:
    """(members, 2 modes, outputs) of an input; the residues are solved for along with the poles."""
    rows = group.columns[0].phi.shape[0]
    vectors = np.concatenate([c.poles.values for c in group.columns])
    projected = vectors - group.q @ (group.q.T @ vectors)
    poles = group.columns[0].poles
    coefficient = group.coefficients[poles.column] / noise
    starts = np.flatnonzero(np.diff(poles.parameter, prepend=-1))
    own = np.split(np.arange(len(poles.parameter)), starts[1:])
    scores: list[Real] = []
    known: list[Real] = []
    for m in range(len(group.members)):
        part = projected[m * rows : (m + 1) * rows]
        left = group.residual[m * rows : (m + 1) * rows] / noise
        scores.append(np.add.reduceat((part.T @ left) * coefficient, starts, axis=0))
        known.append(np.stack([np.sum((part[:, of] @ coefficient[of]) ** 2, axis=0) for of in own]))
    return np.stack(scores), np.stack(known)

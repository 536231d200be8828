"""By how much the poles differ from hit to hit beyond what the noise explains.

The fit's covariance is that of noise. Where the structure itself changes a little from hit to hit, as with the
temperature or a clamp that settles, each hit pulls the poles its own way by more than that. What a hit pulls is its
part of the projected score, times the covariance; the sum of the squares of all pulls is the covariance that holds,
whatever the reason (the sandwich estimate, clustered by hits). Hits of which each knows its share w of a parameter pull
by covariances diag(w) - w w^T under noise alone, which gives the sum's mean and its degrees of freedom.
Sources: White, "Maximum likelihood estimation of misspecified models", Econometrica 50 (1982); Cameron and Miller, "A
practitioner's guide to cluster-robust inference", Journal of Human Resources 50 (2015); Satterthwaite, Biometrics
Bulletin 2 (1946).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri, ndtri, stdtrit

from modallab.identification.likelihood.fit import Fit
from modallab.identification.likelihood.projection import GroupSolution

Real = NDArray[np.float64]

LEAST_FREEDOM = 2.5
"""Degrees of freedom below which hits say nothing of their scatter: four that are alike have three."""
CHANCE = 0.001
"""Noise alone lets the scatter count for a mode's frequency, or its damping, no more often than this."""


def factors_by_scatter(fit: Fit, misfit: float) -> Real:
    """(modes, 2) factors of the sigmas of omega and zeta, 1 where the hits scatter as the noise does.

    The fit takes its residual for noise. Where that is larger than the noise before the hits, the sigmas are too large
    for whatever the misfit does not touch: there the scatter counts between the two. Above, it counts where chance
    would hardly have it. Of few hits the scatter is known roughly, which Student's factor allows for.

    Args:
        fit: of the hits.
        misfit: the residual over the noise before the hits; NaN where that is not known.
    """
    pulls, shares = hit_pulls(fit)
    stated = np.diag(fit.refined.covariance)[: pulls.shape[1]]
    square, cube = np.sum(shares**2, axis=0), np.sum(shares**3, axis=0)
    spare = np.maximum(1 - square, 1e-9)
    freedom = spare**2 / np.maximum(square - 2 * cube + square**2, 1e-12)
    ratio = np.sum(pulls**2, axis=0) / spare / np.maximum(stated, np.finfo(float).tiny)
    enough = freedom >= LEAST_FREEDOM
    freedom = np.maximum(freedom, LEAST_FREEDOM)
    found = stdtrit(freedom, 0.975) / ndtri(0.975) * np.sqrt(ratio)
    least = 1 / max(1.0, misfit) if np.isfinite(misfit) else 1.0
    far = ratio > chdtri(freedom, CHANCE) / freedom
    return np.where(enough, np.where(far, found, np.clip(found, least, 1.0)), 1.0).reshape(-1, 2)


def hit_pulls(fit: Fit) -> tuple[Real, Real]:
    """By how much each hit moves omega and zeta of every mode, and its share of what is known of them.

    Returns:
        (hits, 2 modes) pulls, which add up to about nothing; (hits, 2 modes) shares, which add up to 1.
    """
    n, hits = 2 * fit.point.parameters.omega.size, len(fit.problem.blocks)
    scores, known = np.zeros((hits, n)), np.zeros((hits, n))
    for group in fit.point.groups:
        members = list(group.members)
        scores[members], known[members] = _scores(group, fit.point.noise)
    total = np.maximum(known.sum(axis=0), np.finfo(float).tiny)
    return scores @ fit.refined.covariance[:n, :n], known / total


def _scores(group: GroupSolution, noise: Real) -> tuple[Real, Real]:
    """(members, 2 modes) each hit's part of the cost's derivative by the poles, and of the normal matrix's diagonal.

    The residues are solved for along with the poles.
    """
    rows = group.columns[0].phi.shape[0]
    vectors = np.concatenate([c.poles.values for c in group.columns])
    projected = vectors - group.q @ (group.q.T @ vectors)
    poles = group.columns[0].poles
    coefficient = group.coefficients[poles.column] / noise
    products = coefficient @ coefficient.T
    starts = np.flatnonzero(np.diff(poles.parameter, prepend=-1))
    scores: list[Real] = []
    known: list[Real] = []
    for m in range(len(group.members)):
        own = projected[m * rows : (m + 1) * rows]
        left = group.residual[m * rows : (m + 1) * rows] / noise
        scores.append(np.add.reduceat(np.sum((own.T @ left) * coefficient, axis=1), starts))
        gram = np.add.reduceat(np.add.reduceat((own.T @ own) * products, starts, axis=0), starts, axis=1)
        known.append(np.diag(gram))
    return np.stack(scores), np.stack(known)

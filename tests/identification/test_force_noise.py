"""The force channel's noise as part of the model: its slopes, and what leaving it out would cost."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.identification.impact import identify_impact
from modallab.identification.likelihood.force_noise import force_parts
from modallab.identification.likelihood.normal_matrix import normal_equations
from modallab.identification.likelihood.orthonormal import complex_lines
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import to_signals_of


def fitted(seed=1, hits=3, **how):
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(3)
    system = bench.Modes(system.frequency_hz, system.zeta, system.phi[:, [0, 2, 4]])
    signals = to_signals_of(bench.impact_blocks(system, rng, points=(3,), hits=hits, **how), rig)
    return system, *identify_impact(signals, rig, IdentificationOptions(band_hz=(2.9, 400.0)))


def test_slopes_are_those_of_the_regenerated_blocks():
    _, _, fit = fitted()
    point, block, sample, h = fit.point, 1, 7, 1e-3
    slopes = force_parts(fit.problem, point, point.groups[0]).slopes[block][:, :, sample] * point.noise
    excitation = fit.problem.blocks[block].excitation
    moved = []
    for sign in (1, -1):
        force = point.parameters.force.copy()
        force[block, sample] += sign * h
        there = replace(fit.refined, point=replace(point, parameters=replace(point.parameters, force=force)))
        moved.append(replace(fit, refined=there).regenerated(block, excitation))
    numeric = (moved[0] - moved[1]) / (2 * h)
    np.testing.assert_allclose(complex_lines(slopes), numeric, atol=1e-6 * np.abs(numeric).max())


def test_the_normal_equations_are_those_of_the_projected_slopes():
    """J written out for one output after the other, P the projector off the columns, Kaufman's derivative."""
    _, _, fit = fitted(hits=2)
    problem, point = fit.problem, fit.point
    equations = normal_equations(problem, point)
    matrix, gradient = equations.whole(), equations.pull
    group, n_poles = point.groups[0], 2 * point.parameters.omega.size
    rows, width = group.columns[0].phi.shape[0], problem.n_local
    n_states = width - point.parameters.force.shape[1]
    parts = force_parts(problem, point, group).slopes
    vectors = group.columns[0].poles
    expected, slope = np.zeros_like(matrix), np.zeros_like(gradient)
    for o in range(3):
        jacobian = np.zeros((2 * rows, len(matrix)))
        for m, found in enumerate(group.columns):
            here = slice(m * rows, (m + 1) * rows)
            weighted = found.poles.values * (group.coefficients[found.poles.column, o] / point.noise[o])
            for i in range(n_poles):
                jacobian[here, i] = weighted[:, vectors.parameter == i].sum(axis=1)
            begin = n_poles + m * width
            state = found.local.values * (group.coefficients[found.local.column, o] / point.noise[o])
            for i in range(n_states):
                jacobian[here, begin + i] = state[:, found.local.parameter == i].sum(axis=1)
            jacobian[here, begin + n_states : begin + width] = parts[m][:, o]
        projected = jacobian - group.q @ (group.q.T @ jacobian)
        expected += projected.T @ projected
        slope += projected.T @ group.residual[:, o] / point.noise[o]
    own = np.concatenate([problem.state_sigma.repeat(2, axis=1), problem.force_sigma], axis=1)
    prior = np.concatenate([problem.zeta_prior[:, 1].repeat(2) ** -2.0, own.ravel() ** -2.0])
    prior[:n_poles:2] = 0
    expected += np.diag(prior)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(matrix / scale, expected / scale, atol=1e-8)
    states = np.stack([point.parameters.state.real, point.parameters.state.imag], axis=-1).reshape(2, -1)
    data = gradient[n_poles:] + (np.concatenate([states, point.parameters.force], axis=1) / own**2).ravel()
    size = np.sqrt(np.diag(expected))[n_poles:]
    np.testing.assert_allclose(data / size, slope[n_poles:] / size, atol=1e-6)


@pytest.mark.thorough("identifies many recordings")
def test_a_noisy_force_does_not_bias_what_the_responses_know_well():
    """Ten times the force noise with responses of little noise: the errors stay within the stated sigmas."""
    normalised = []
    for seed in range(3):
        system, model, _ = fitted(seed, hits=4, noise=0.003, force_noise=0.15)
        normalised += list((model.frequency_hz - system.frequency_hz) / model.frequency_sigma_hz)
        normalised += list((model.damping_ratio - system.zeta) / model.damping_sigma)
    assert np.sqrt(np.mean(np.square(normalised))) < 1.8


def test_the_errors_found_are_no_larger_than_the_noise():
    _, _, fit = fitted(2, noise=0.003, force_noise=0.15)
    change = fit.point.parameters.force
    # The errors found scatter with part of the noise's own sigma, never with more.
    assert 0.02 < change.std() / 0.15 < 1.05

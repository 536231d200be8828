"""The twin as a state space: forces at the points of the rig in, what the response channels read out.

Real modal form (Franklin, Powell and Emami-Naeini, Feedback Control of Dynamic Systems, 2019, ch. 7): a pole p and its
conjugate are two states. Of an acceleration s^2 / (s - p) = s + p + p^2 / (s - p), the first term sums to nothing over
all modes. What the modes left out add is static; their mass is one fast mode an input. A step of time holds a straight
line between two samples of the force (Franklin, Powell and Workman, Digital Control of Dynamic Systems, 1998, ch. 6).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat, savemat
from scipy.linalg import block_diag
from scipy.signal import cont2discrete

from modallab.core.arrays import Complex, Real
from modallab.core.errors import FormatError, PlanError
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.atomic import replacing
from modallab.gap.export.mjcf_laws import require_linear_twin
from modallab.twin.bench import MeasurementChain, Twin
from modallab.twin.modes import TwinModes, solve_modes
from modallab.twin.predict import sensor_positions

FAST = 6.0
"""Frequency of what stands for the modes left out, over that of the highest one kept."""
FAST_ZETA = 0.05


@dataclass(frozen=True, eq=False, slots=True)
class StateSpace:
    """x' = A x + B f, y = C x + D f; f (points,) in N along the drive, y (channels,) in SI units along the drive.

    Attributes:
        A, B, C, D: the matrices.
        delay_s: (channels,) by how much each output is late beside that.
        clock: by how much faster the converter's clock runs than it says: a second of the records is 1 / (1 + clock).
    """

    A: Real
    B: Real
    C: Real
    D: Real
    delay_s: Real
    clock: float = 0.0

    @property
    def first_hz(self) -> float:
        """Frequency of the first mode, of what swings at all; 0 if nothing does."""
        poles = np.linalg.eigvals(self.A)
        swinging = np.abs(poles[poles.imag > 0])
        return float(swinging.min()) / (2 * np.pi) if swinging.size else 0.0

    def at_rate(self, rate_hz: float) -> tuple[Real, Real, Real, Real]:
        """The same in steps: x_{k+1} = A x_k + B f_k, y_k = C x_k + D f_k, f on straight lines between samples."""
        dt = 1 / rate_hz / (1 + self.clock)
        found = cont2discrete((self.A, self.B, self.C, self.D), dt, method="foh")
        A, B, C, D = (np.asarray(m, dtype=np.float64) for m in found[:4])
        return A, B, C, D

    def simulate(self, force_n: Real, dt: float) -> Real:
        """(channels, n) what the channels read of (points, n) forces in N, from rest, in steps of dt seconds."""
        A, B, C, D = self.at_rate(1 / dt)
        driven = np.flatnonzero(np.any(force_n != 0, axis=1))
        pushed = (B[:, driven] @ force_n[driven]).T
        # From rest: what a straight line into the first sample would have left is none of it.
        states = np.zeros((force_n.shape[1], len(A)))
        for k in range(1, len(states)):
            states[k] = A @ states[k - 1] + pushed[k - 1]
        y = C @ states.T + D[:, driven] @ force_n[driven]
        return _delay_samples(y, self.delay_s / dt) if np.any(self.delay_s) else y


def state_space(twin: Twin, rig: Rig, test: Test) -> StateSpace:
    """The twin in one test, as it is when the first record is made.

    In the sine test the shaker hangs on the beam; hits land where they land, by the twin.

    Args:
        twin: the bench.
        rig: its points are the inputs, its response channels the outputs.
        test: which one.

    Raises:
        DataError: the twin is not linear.
    """
    require_linear_twin(twin, "a state space")
    hit = test == "impact"
    structure = twin.structure
    if not hit and rig.shaker_point is not None:
        structure = twin.in_sine(rig.x_of(rig.shaker_point))
    modes = solve_modes(structure)
    drive = np.array([twin.struck_x_m(p.x_m) if hit else p.x_m for p in rig.points])
    rows = tuple(c.index for c in rig.responses)
    x = sensor_positions(twin.chain, modes, rows, np.array([rig.x_of(c.point or 0) for c in rig.responses]))
    order = np.array([2 - twin.chain.integrals.get(row, 0) for row in rows])
    bare = _with_residual(
        modal_state_space(modes.poles, modes.shapes_at(x), modes.shapes_at(drive), order), twin, modes, x, drive, order
    )
    chained = _add_measurement_chain(bare, twin.chain, rows, test)
    gains = np.array([twin.hit_gain(p.x_m) if hit else 1.0 for p in rig.points])
    return replace(chained, B=chained.B * gains, D=chained.D * gains, clock=twin.clock)


def modal_state_space(poles: Complex, out: Complex, into: Complex, order: NDArray[np.int64]) -> StateSpace:
    """The state space of modes.

    Args:
        poles: (p,) rad/s, one of each conjugate pair.
        out: (channels, p) shapes where the outputs are, scaled as in `TwinModes`.
        into: (points, p) shapes where the forces act.
        order: (channels,) times the displacement is differentiated.
    """
    A = block_diag(*(np.array([[p.real, -p.imag], [p.imag, p.real]], dtype=np.float64) for p in poles))
    B = np.asarray(np.stack([into.real.T, into.imag.T], axis=1), dtype=np.float64).reshape(-1, len(into))
    seen = 2 * out * poles ** order[:, None]
    C = np.stack([seen.real, -seen.imag], axis=2).reshape(len(out), -1)
    # At once an acceleration answers: the inverse of the mass that the modes carry.
    D = np.where(order[:, None] == 2, 2 * np.real((out * poles) @ into.T), 0.0)
    return StateSpace(A, B, C, D, np.zeros(len(out)))


def _with_residual(
    bare: StateSpace, twin: Twin, modes: TwinModes, x: Real, drive: Real, order: NDArray[np.int64]
) -> StateSpace:
    """With the static compliance of the modes left out, as one fast mode an input."""
    if not twin.residual_compliance:
        return bare
    R = twin.residual_compliance * np.stack([modes.remainder(x, float(d)) for d in drive], axis=1)
    omega = FAST * float(np.max(np.abs(modes.poles)))
    n = len(drive)
    A = np.kron(np.eye(n), [[0.0, 1.0], [-(omega**2), -2 * FAST_ZETA * omega]])
    B = np.asarray(np.kron(np.eye(n), [[0.0], [omega**2]]), dtype=np.float64)
    rows = {0: [1.0, 0.0], 1: [0.0, 1.0], 2: [-(omega**2), -2 * FAST_ZETA * omega]}
    C = np.array([np.kron(R[k], rows[int(o)]) for k, o in enumerate(order)])
    D = np.where(order[:, None] == 2, R * omega**2, 0.0)
    return StateSpace(block_diag(bare.A, A), np.vstack([bare.B, B]), np.hstack([bare.C, C]), bare.D + D, bare.delay_s)


def _add_measurement_chain(bare: StateSpace, chain: MeasurementChain, rows: tuple[int, ...], test: Test) -> StateSpace:
    """What the measurement chain makes of it: gains, exchanged plugs, loose mounts, AC coupling, delays."""
    gain = np.array([chain.gain.get(row, 1.0) for row in rows])[:, None] / chain.force_gain
    found = replace(bare, C=bare.C * gain, D=bare.D * gain)
    for mount in chain.mounts:
        omega, zeta = 2 * np.pi * mount.hz, mount.zeta
        A = np.array([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]])
        found = _filter_output(
            found, rows.index(mount.channel), A, np.array([0.0, 1.0]), [omega**2, 2 * zeta * omega], 0.0
        )
    if chain.corner_hz:
        corner = 2 * np.pi * chain.corner_hz
        for k in range(len(rows)):
            found = _filter_output(found, k, np.array([[-corner]]), np.array([corner]), [-1.0], 1.0)
    for row, hz in chain.low_pass_hz:
        corner = 2 * np.pi * hz
        found = _filter_output(found, rows.index(row), np.array([[-corner]]), np.array([corner]), [1.0], 0.0)
    for row, hz in chain.own_corner_hz.items():
        corner = 2 * np.pi * hz
        found = _filter_output(found, rows.index(row), np.array([[-corner]]), np.array([corner]), [-1.0], 1.0)
    delay = np.array([chain.delay_s - row * chain.skew_s + chain.lag_s.get(row, 0.0) for row in rows])
    found = replace(found, delay_s=delay)
    return found if chain.swap is None else _exchange_plugs(found, chain, rows, test)


def _filter_output(s: StateSpace, k: int, a: Real, b: Real, c: list[float], d: float) -> StateSpace:
    """One output through a filter of its own."""
    n = len(a)
    A = np.block([[s.A, np.zeros((len(s.A), n))], [np.outer(b, s.C[k]), a]])
    B = np.vstack([s.B, np.outer(b, s.D[k])])
    C, D = np.hstack([s.C, np.zeros((len(s.C), n))]), s.D.copy()
    C[k], D[k] = np.concatenate([d * s.C[k], c]), d * s.D[k]
    return replace(s, A=A, B=B, C=C, D=D)


def _exchange_plugs(s: StateSpace, chain: MeasurementChain, rows: tuple[int, ...], test: Test) -> StateSpace:
    assert chain.swap is not None
    ratio = chain.swap_ratio.get(test, 1.0)
    i, j = (rows.index(row) for row in chain.swap)
    C, D = s.C.copy(), s.D.copy()
    C[i], C[j], D[i], D[j] = s.C[j] * ratio, s.C[i] / ratio, s.D[j] * ratio, s.D[i] / ratio
    return replace(s, C=C, D=D)


def _delay_samples(y: Real, samples: Real) -> Real:
    steps = np.arange(y.shape[1], dtype=np.float64)
    return np.stack([np.interp(steps - late, steps, row) for row, late in zip(y, samples, strict=True)])


MATRICES = ("A", "B", "C", "D")


def write_state_space(path: Path, systems: Mapping[Test, StateSpace], rig: Rig, rate_hz: float | None) -> None:
    """Write the systems of each test, continuous and, with a rate, in steps; `.mat` is MATLAB's, anything else NPZ.

    Raises:
        PlanError: at that rate the steps would show no mode.
        StorageError: the file cannot be written.
    """
    if rate_hz is not None:
        _require_rate(systems, rate_hz)
    content: dict[str, Any] = {
        "points": np.array([p.id for p in rig.points]),
        "channels": np.array([c.name for c in rig.responses]),
        "quantities": np.array([c.quantity for c in rig.responses]),
    }
    for test, system in systems.items():
        content |= {f"{name}_{test}": getattr(system, name) for name in MATRICES}
        content |= {f"delay_s_{test}": system.delay_s, f"clock_{test}": system.clock}
        if rate_hz is not None:
            stepped = system.at_rate(rate_hz)
            content |= {f"{name}d_{test}": value for name, value in zip(MATRICES, stepped, strict=True)}
            content["rate_hz"] = rate_hz
    with replacing(path) as draft:
        if path.suffix == ".mat":
            savemat(str(draft), content, appendmat=False)
        else:
            with draft.open("wb") as out:
                np.savez_compressed(out, **content)


def _require_rate(systems: Mapping[Test, StateSpace], rate_hz: float) -> None:
    first_hz = max(system.first_hz for system in systems.values())
    if rate_hz <= 2 * first_hz:
        raise PlanError(
            f"the rate of {rate_hz:g} Hz is too low: the first mode is at {first_hz:.4g} Hz",
            remedy=f"give a rate well above {2 * first_hz:.3g} Hz, preferably that of the records",
        )


def read_state_space(path: Path) -> dict[Test, StateSpace]:
    """The continuous systems of a file, by test.

    Raises:
        FormatError: it is no such file.
    """
    try:
        content: Mapping[str, Any] = loadmat(path) if path.suffix == ".mat" else np.load(path)
        tests: list[Test] = [test for test in ("impact", "sine") if f"A_{test}" in content]
        return {test: _read_system(content, test) for test in tests}
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise FormatError(f"is no state space: {error}", where=str(path), remedy="export it again") from error


def _read_system(content: Mapping[str, Any], test: Test) -> StateSpace:
    A, B, C, D = (np.asarray(content[f"{name}_{test}"], dtype=np.float64) for name in MATRICES)
    delay = np.asarray(content[f"delay_s_{test}"], dtype=np.float64).ravel()
    return StateSpace(A, B, C, D, delay, float(np.asarray(content[f"clock_{test}"]).item()))

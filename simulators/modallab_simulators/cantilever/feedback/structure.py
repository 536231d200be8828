"""The structure with its local nonlinearities: the linear one, driven also by what they feed back."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.attached import KEPT
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.feedback.elements import (
    FITTED,
    CrackElement,
    Drag,
    ForceChannel,
    PointElement,
    channels_of,
    static_remainder,
)
from modallab_simulators.cantilever.feedback.time_stepping import CRACK, CUBIC, FRICTION, PLAY, step_in_time
from modallab_simulators.cantilever.loads import BLOCK, BeamLoad, DistributedLoad
from modallab_simulators.cantilever.recursion import REACH, step_taps
from modallab_simulators.cantilever.structure import LinearStructure

SUBSTEPS = 2
"""Per internal sample: a force that runs straight over a sixteenth of a millisecond is right to 5e-4 at 200 Hz."""

_KINDS = {"cubic": CUBIC, "friction": FRICTION, "play": PLAY, "crack": CRACK}
_AHEAD = REACH + 2


@dataclass(frozen=True, eq=False, slots=True)
class FeedbackState:
    """All a stretch needs to know of the past.

    Attributes:
        linear: state of the linear structure.
        z: the modes at the last fed-back sample.
        g: forces there.
        memory: of sliders.
        past: forces over the samples before, (channels, samples).
    """

    linear: Complex128
    z: Complex128
    g: Real
    memory: Real
    past: Real

    def any(self) -> bool:
        """Whether anything moves or is held in tension."""
        return bool(self.linear.any() or self.z.any() or self.g.any() or self.past.any())


class FeedbackStructure:
    """A structure whose local elements are solved step by step, and then drive the linear one as known forces."""

    def __init__(
        self, linear: LinearStructure, elements: Sequence[PointElement | CrackElement], drag: Drag | None, step_s: float
    ) -> None:
        self._linear, self._step_s = linear, step_s
        self._basis = linear.basis
        self._elements = tuple(elements)
        self._groups = [channels_of(e, self._basis) for e in self._elements]
        self._local = [channel for group in self._groups for channel in group]
        self._drag = drag
        self._set_marching()
        self._loads = [*map(self._load, self._local), *self._drag_loads()]
        self._intos: dict[tuple[float, str], tuple[Complex128, Real]] = {}

    @property
    def oversample(self) -> int:
        """Internal samples per delivered one."""
        return self._linear.oversample

    @property
    def force_delay(self) -> int:
        """Delivered samples by which the force is delayed."""
        return self._linear.force_delay

    @property
    def at_rest(self) -> FeedbackState:
        """The state of a beam that has never moved."""
        channels = len(self._loads)
        first, _ = self._linear.times(0)
        modes = np.zeros(len(self._decay), dtype=np.complex128)
        memory = np.zeros((len(self._elements), 4))
        return FeedbackState(self._linear.at_rest, modes, np.zeros(channels), memory, np.zeros((channels, -first)))

    def times(self, block: int) -> tuple[int, int]:
        """First internal sample and number of those whose force the stretch `block` needs."""
        first, count = self._linear.times(block)
        return first, count + _AHEAD

    def state_from(self, other: "FeedbackStructure", state: FeedbackState) -> FeedbackState:
        """This structure's state where every mode moves as another's does."""
        linear = self._linear.state_from(other._linear, state.linear)
        return replace(state, linear=linear, z=self._linear.state_from(other._linear, state.z))

    def advance(self, state: FeedbackState, drives: Sequence[BeamLoad]) -> tuple[Real, FeedbackState]:
        """Filtered outputs of one stretch in SI units, (outputs, BLOCK), and the state for the next."""
        loads, after = self._fed(state, drives)
        seen, linear = self._linear.advance(state.linear, loads)
        return seen, replace(after, linear=linear)

    def skip(self, state: FeedbackState, drives: Sequence[BeamLoad]) -> FeedbackState:
        """The state after a stretch of which nobody wants the outputs."""
        loads, after = self._fed(state, drives)
        return replace(after, linear=self._linear.skip(state.linear, loads))

    def _fed(self, state: FeedbackState, drives: Sequence[BeamLoad]) -> tuple[list[BeamLoad], FeedbackState]:
        """All loads of a stretch on the linear structure, and the state for the next but for that structure's own."""
        _, count = self._linear.times(0)
        step, ahead = BLOCK * self.oversample, count - state.past.shape[1]
        if not drives and not state.any():
            still = np.zeros((len(self._loads), count - step))
            return [], replace(state, past=still)
        new, fed = self._marched(state, drives, ahead)
        forces = np.concatenate([state.past, fed], axis=1)
        loads = [replace(d, force_n=d.force_n[:count]) for d in drives]
        loads += [replace(load, force_n=force) for load, force in zip(self._loads, forces, strict=True)]
        return loads, replace(new, past=forces[:, step:])

    def _marched(self, state: FeedbackState, drives: Sequence[BeamLoad], count: int) -> tuple[FeedbackState, Real]:
        begin = state.past.shape[1] - 1 - REACH
        forces = np.zeros((len(drives), count + 2 * REACH + 1))
        into, direct = np.zeros((len(drives), len(state.z)), complex), np.zeros((len(self._local), len(drives)))
        for row, drive in enumerate(drives):
            forces[row] = drive.force_n[begin : begin + forces.shape[1]]
            into[row], direct[:, row] = self._known(drive)
        g, memory, fed = state.g.copy(), state.memory.copy(), np.zeros((len(self._loads), count))
        parts = _parts(state.z)
        step_in_time(parts, g, memory, forces, _parts(into), *self._fixed[:6], direct, *self._fixed[6:], REACH, fed)
        return replace(state, z=parts[0] + 1j * parts[1], g=g, memory=memory), fed

    def _known(self, drive: BeamLoad) -> tuple[Complex128, Real]:
        """What a known load puts into each mode, and at once into each local motion."""
        key = (drive.x_m, drive.load)
        if key not in self._intos:
            basis, at = self._basis, np.array([drive.x_m])
            if drive.load == "base":
                row = -basis.modes.participation(KEPT)
                channel = ForceChannel(basis.participation, row)
            else:
                channel = ForceChannel(basis.shapes(at)[0], basis.modes.shapes(at, KEPT)[0], (drive.x_m, 0))
            direct = np.array([static_remainder(basis, local, channel) for local in self._local])
            self._intos[key] = (channel.psi.astype(np.complex128), direct)
        return self._intos[key]

    def _set_marching(self) -> None:
        basis, step_s = self._basis, self._step_s / SUBSTEPS
        self._decay = np.exp(basis.poles * step_s)
        taps = np.stack(
            [step_taps(basis.poles, self._step_s, s / SUBSTEPS, (s + 1) / SUBSTEPS).T for s in range(SUBSTEPS)]
        )
        begin, end = _straight(basis.poles, step_s)
        drag_psi, drag_seen, drag_put = self._drag_rows()
        psi = np.array([*(c.psi for c in self._local), *drag_psi], dtype=np.complex128)
        seen = np.array([c.psi / basis.scale for c in self._local], dtype=np.complex128)
        seen = seen.reshape(len(self._local), len(self._decay))
        b = (seen @ (psi[: len(self._local)] * end).T).imag + self._static_among()
        crack = self._cracks(b)
        firsts = np.cumsum([0, *map(len, self._groups)]).astype(np.int64)
        kinds = np.array([_KINDS[e.law] for e in self._elements], dtype=np.int64)
        numbers = np.array([(*e.numbers, 0.0, 0.0)[:2] for e in self._elements]).reshape(-1, 2)
        self._fixed = (
            _parts(self._decay),
            _parts(taps),
            _parts(psi * begin),
            _parts(psi * end),
            _parts(seen / 1j),
            b,
            kinds,
            firsts,
            numbers,
            crack,
            _parts(drag_seen / 1j),
            drag_put,
        )

    def _static_among(self) -> Real:
        """What channels do to each other at once, beyond the modes; a forced curvature carries no moment itself."""
        among = np.zeros((len(self._local), len(self._local)))
        for i, one in enumerate(self._local):
            for j, other in enumerate(self._local):
                among[i, j] = static_remainder(self._basis, one, other)
        for group, element in zip(self._groups, self._elements, strict=True):
            if isinstance(element, CrackElement):
                own = [next(k for k, c in enumerate(self._local) if c is channel) for channel in group]
                kept = np.array([[_kept(self._basis, a, b) for b in group] for a in group])
                among[np.ix_(own, own)] = -kept
        return among

    def _cracks(self, b: Real) -> Real:
        crack, first = np.zeros((len(self._elements), FITTED + 1, FITTED)), 0
        for row, (element, group) in enumerate(zip(self._elements, self._groups, strict=True)):
            last = first + len(group)
            if isinstance(element, CrackElement):
                compliance = element.compliance(self._basis.modes.length_m)
                crack[row, : len(group), : len(group)] = np.linalg.inv(compliance - b[first:last, first:last])
                crack[row, -1, : len(group)] = np.linalg.inv(compliance)[0]
            first = last
        return crack

    def _drag_rows(self) -> tuple[Complex128, Complex128, Real]:
        basis, n = self._basis, len(self._basis.poles)
        if self._drag is None:
            return np.zeros((0, n), complex), np.zeros((0, n), complex), np.zeros((0, 0))
        single = np.eye(self._drag.MODES, KEPT)
        psi = basis.project(single).astype(np.complex128)
        seen = self._drag.sensed_motion(basis.modes) @ psi * basis.poles / basis.scale
        seen = seen[:, : np.flatnonzero(seen.any(axis=0))[-1] + 1]
        return psi, seen, np.ascontiguousarray(self._drag.put(basis.modes).T)

    def _load(self, channel: ForceChannel) -> BeamLoad:
        nothing = np.zeros(0)
        if channel.point is not None:
            return BeamLoad(channel.point[0], nothing, 0.0, "moment" if channel.point[1] else "force", seen=False)
        modes, places = self._basis.modes, self._linear.places_m
        whole = modes.shapes(places, KEPT) @ (channel.row / modes.omega(KEPT) ** 2)
        kept = (self._basis.shapes(places) * channel.psi / (-self._basis.poles * self._basis.scale)).imag.sum(axis=1)
        return BeamLoad(0.0, nothing, 0.0, "spread", False, DistributedLoad(channel.psi, whole - kept))

    def _drag_loads(self) -> list[BeamLoad]:
        still = np.zeros(len(self._linear.places_m))
        rows = self._drag_rows()[0]
        return [BeamLoad(0.0, np.zeros(0), 0.0, "spread", False, DistributedLoad(psi, still)) for psi in rows]


def _parts(numbers: Complex128) -> Real:
    """Real and imaginary parts as rows before the last axis."""
    return np.ascontiguousarray(np.stack([numbers.real, numbers.imag], axis=-2))


def _kept(basis: Basis, one: ForceChannel, other: ForceChannel) -> float:
    return float((one.psi * other.psi / (-basis.poles * basis.scale)).imag.sum())


def _straight(poles: Complex128, step_s: float) -> tuple[Complex128, Complex128]:
    """What a force that runs straight over a step puts into z, by its value at the beginning and at the end."""
    x = poles * step_s
    end = step_s * (np.exp(x) - 1 - x) / x**2
    return step_s * (np.exp(x) - 1) / x - end, end

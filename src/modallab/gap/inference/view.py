"""The reduced data as the rows of the objective: poles, damping and modal constants of hits, sines, the clock.

An effect moves poles and modal constants smoothly. Lines of a record answer a moved resonance by its whole height, and
a fit to them has a local minimum for every half width; these rows have none.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex
from modallab.gap.conditioning.reduce import LINES
from modallab.gap.conditioning.rows import Reduced, SineData
from modallab.gap.inference.discrepancy import ObjectiveRows, ScaledObjective
from modallab.gap.inference.identified import PointModes
from modallab.gap.inference.settings import Settings
from modallab.gap.model.fit import GENERATOR, Problem
from modallab.gap.model.forward import forward, impact_residue, with_shaker
from modallab.gap.model.sensitivity import Tangent, differ_smoothly, neighbouring_modes
from modallab.twin.bench import Twin, chain_transfer, exchange_plugs
from modallab.twin.modes import TwinModes, solve_modes

Array = NDArray[np.float64]
SineScales = Literal["channel", "record"]
"""What shares a scale of the discrepancy in a sine test: a channel, or the lines about a record's sine or overtone."""
Match = tuple[NDArray[np.intp], ...]
"""For each drive point, (p,) which mode of the twin each identified pole is."""

STEP = 1e-4
"""Step of a numerical derivative, in deviations of a prior or in coordinates of an effect."""
SKIPPED = 0.15
"""Distance in log frequency that skipping a mode of the twin counts for, where poles are matched to modes."""


@dataclass(frozen=True, eq=False, slots=True)
class RowModel:
    """ObjectiveRows, and what a twin predicts for them.

    Attributes:
        points: identified modes of the hits.
        data: all reduced data, of which the hits are not used beyond `points`.
        sines: the data without hits.
        objective: of the rows.
        modal: number of the rows that come from the hits.
    """

    points: tuple[PointModes, ...]
    data: Reduced
    sines: Reduced
    objective: ScaledObjective
    modal: int

    @classmethod
    def of(
        cls, points: tuple[PointModes, ...], data: Reduced, settings: Settings, scales: SineScales = "channel"
    ) -> "RowModel":
        """The rows of reduced data whose hits were identified, and what shares a scale in the sine test."""
        of_sines = [] if data.sines is None else _sine_groups(data.sines, data, scales)
        names = ("poles", *(f"impact {c}" for c in data.channels), *of_sines, "clock")
        modal = [part for p in points for part in _modal_rows(p, len(data.channels), names, settings)]
        sines = _sine_rows(data.sines, len(data.channels), names, settings, scales) if data.sines is not None else []
        rows = ObjectiveRows.joined([ObjectiveRows.none(names), *modal, *sines])
        count = sum(len(part.z) for part in modal)
        return cls(points, data, replace(data, impacts=()), ScaledObjective(rows, settings), count)

    @property
    def z(self) -> Array:
        """(rows,) measured."""
        return self.objective.rows.z

    def matched(self, twin: Twin) -> Match:
        """Which mode of a twin each identified pole is."""
        modes = solve_modes(twin.structure)
        return tuple(_matching_modes(q.poles, self._predicted(twin, modes, q)[0]) for q in self.points)

    def predict(self, twin: Twin, match: Match | None = None) -> Array:
        """(rows,) what a twin says; the poles are matched to its modes where that is not given."""
        parts = [self._modal(twin, solve_modes(twin.structure), match)]
        if self.sines.sines is not None:
            parts += [_as_vector(forward(twin, self.sines)), np.array([1 / (1 + twin.clock)])]
        return np.concatenate(parts)

    def residual(self, twin: Twin, match: Match | None = None) -> Array:
        """(rows,) measured less predicted; far off where a prediction is not finite."""
        return self.residual_after(self.predict(twin, match))

    def residual_after(self, predicted: Array) -> Array:
        """(rows,) measured less what was predicted."""
        return np.nan_to_num(self.z - predicted, posinf=1e6, neginf=-1e6)

    def slopes(self, problem: Problem, u: Array, match: Match, at: Array) -> Array:
        """(rows, u) slopes of the prediction, `at` being that at u."""
        here, twins = problem.twin(u), problem.twins(u + STEP * np.eye(len(u)))
        n = problem.free.size
        # Of the nuisances, which are many and small, the first order of the eigenvalue problem will do.
        order = [*range(n, len(u)), *range(n)]
        near = neighbouring_modes(
            solve_modes(here.structure), here.structure, [twins[k].structure for k in order], len(u) - n
        )
        J = np.zeros((len(u), len(at)))
        for k, modes in zip(order, near, strict=True):
            J[k, : self.modal] = (self._modal(twins[k], modes, match) - at[: self.modal]) / STEP
        if self.sines.sines is not None:
            J[:, self.modal : -1] = self._sine_slopes(here, twins, n, at[self.modal : -1])
            J[:, -1] = [(1 / (1 + t.clock) - at[-1]) / STEP for t in twins]
        return np.nan_to_num(J.T)

    def _sine_slopes(self, here: Twin, twins: Sequence[Twin], nuisances: int, at: Array) -> Array:
        J = np.full((len(twins), len(at)), np.nan)
        smooth = sorted((k for k, t in enumerate(twins) if differ_smoothly(here, t)), key=lambda k: k < nuisances)
        if smooth:
            near = sum(k < nuisances for k in smooth)
            changes = Tangent(here, self.sines).changes([twins[k] for k in smooth], near)
            flat = np.concatenate([c.reshape(len(smooth), -1) for c in changes], axis=1)
            J[smooth] = np.concatenate([flat.real, flat.imag], axis=1) / STEP
        for k, twin in enumerate(twins):
            if np.isnan(J[k, 0]):
                J[k] = (_as_vector(forward(twin, self.sines)) - at) / STEP
        return J

    def _modal(self, twin: Twin, modes: TwinModes, match: Match | None) -> Array:
        parts = [np.zeros(0)]
        for k, q in enumerate(self.points):
            poles, constants = self._predicted(twin, modes, q)
            own = _matching_modes(q.poles, poles) if match is None else match[k]
            poles, used = poles[own], q.where_used(constants[:, own])
            damping = np.maximum(-poles.real / np.abs(poles), 1e-6)
            parts += [np.log(np.abs(poles)), np.log(damping), *_parts(used)]
        return np.concatenate(parts)

    def _predicted(self, twin: Twin, modes: TwinModes, q: PointModes) -> tuple[Complex, Complex]:
        """(modes,) poles and (channels, modes) modal constants as they would be identified from the hits at a point."""
        own = with_shaker(twin, modes, self.data) if q.data.piece.by_shaker else modes
        poles, constants = impact_residue(twin, own, q.data, self.data)
        constants = constants * chain_transfer(twin.chain, self.data.channels, poles)
        if twin.clock:
            poles, constants = poles / (1 + twin.clock), constants * (1 + twin.clock)
        return poles, exchange_plugs(twin.chain, self.data.channels, q.data.piece.test, constants)


def _modal_rows(q: PointModes, channels: int, names: tuple[str, ...], settings: Settings) -> list[ObjectiveRows]:
    n, damping = len(q.poles), q.damping
    of_poles = np.zeros(n, np.intp)
    constants = q.where_used(q.constants)
    size = _reference_size(constants, settings.node, axis=0).ravel()
    group, sigma = np.repeat(1 + np.arange(channels), n), q.constant_sigma.ravel()
    log_damping = (q.angle_sigma * np.sqrt(1 - damping**2) / damping).astype(np.float64)
    return [
        ObjectiveRows(np.log(np.abs(q.poles)), q.log_sigma, np.full(n, settings.frequency_share), of_poles, names),
        ObjectiveRows(
            np.log(damping), log_damping.astype(np.float64), np.full(n, settings.damping_share), of_poles, names
        ),
        *(ObjectiveRows(part, sigma, size, group, names) for part in _parts(constants)),
    ]


def _sine_groups(d: SineData, data: Reduced, scales: SineScales) -> list[str]:
    """Names of the groups of rows of a sine test."""
    if scales == "channel":
        return [f"sine {c}" for c in data.channels]
    orders = d.source.lines.shape[1] // LINES
    return [f"{piece.name}, group {k + 1}" for piece in d.pieces for k in range(orders)]


def _sine_rows(
    d: SineData, channels: int, names: tuple[str, ...], settings: Settings, scales: SineScales
) -> list[ObjectiveRows]:
    y, sigma = d.rows.y, d.rows.sigma.ravel()
    size = _reference_size(y, settings.node, axis=0).ravel()
    by_channel, by_record = np.indices(y.shape)
    group = (1 + channels + (by_channel if scales == "channel" else by_record // LINES)).ravel()
    clock = np.array([len(names) - 1], np.intp)
    return [
        *(ObjectiveRows(part, sigma, size, group, names) for part in _parts(y)),
        # Nothing on a bench moves the generator's own line but a clock: no discrepancy.
        ObjectiveRows(np.array([d.ratio]), np.array([max(d.ratio_sigma, GENERATOR)]), np.zeros(1), clock, names),
    ]


def _reference_size(values: Complex, node: float, axis: int) -> Array:
    """The size of each value, at a node a share of the rms along the axis."""
    size = np.abs(values).astype(np.float64)
    return np.maximum(size, node * np.sqrt(np.mean(size**2, axis=axis, keepdims=True)))


def _parts(values: Complex) -> tuple[Array, Array]:
    return values.real.ravel().astype(np.float64), values.imag.ravel().astype(np.float64)


def _as_vector(answers: Sequence[Complex]) -> Array:
    return np.concatenate([part for y in answers for part in _parts(y)])


def _matching_modes(poles: Complex, modes: Complex) -> NDArray[np.intp]:
    """(p,) modes in the order of the poles, the sum of log distances least (dynamic programming: Bellman, 1957)."""
    n, m = len(poles), len(modes)
    far = np.abs(np.log(np.abs(poles))[:, None] - np.log(np.abs(modes)))
    if n <= m and np.trace(far[:, :n]) <= SKIPPED:
        # Any mode skipped would cost more.
        return np.arange(n)
    best, taken = np.full((n + 1, m + 1), np.inf), np.zeros((n + 1, m + 1), bool)
    best[0] = 0.0
    for i in range(1, n + 1):
        for j in range(i, m + 1):
            take = best[i - 1, j - 1] + far[i - 1, j - 1] + SKIPPED * (j - i)
            taken[i, j] = take <= best[i, j - 1]
            best[i, j] = min(take, best[i, j - 1])
    found, i, j = np.zeros(n, np.intp), n, m
    while i > 0 and j > 0:
        if taken[i, j]:
            i -= 1
            found[i] = j - 1
        j -= 1
    return found


def sparse(data: Reduced) -> Reduced:
    """The data for a first look: of the sines the line of the drive alone, at the largest force of each frequency."""
    d = data.sines
    if d is None:
        return data
    source = d.source
    hz = np.round(source.frequency_hz, 3)
    loudest = [max(np.flatnonzero(hz == f), key=lambda k: abs(source.force[k])) for f in np.unique(hz)]
    keep = np.sort(np.array(loudest))
    count = source.lines.shape[1]
    at = keep * count + count // 2
    old = source.rise
    rise = replace(
        old,
        history_s=old.history_s[keep],
        ramp_s=old.ramp_s[keep],
        cosine=old.cosine[keep],
        counted=old.counted[keep],
    )
    middle = source.lines[keep][:, [count // 2]]
    thin = replace(source, lines=middle, frequency_hz=source.frequency_hz[keep], force=source.force[keep], rise=rise)
    rows = replace(
        d.rows,
        y=d.rows.y[:, at],
        sigma=d.rows.sigma[:, at],
        common=d.rows.common[at],
        direction=d.rows.direction[:, at],
    )
    return replace(data, sines=replace(d, pieces=tuple(d.pieces[k] for k in keep), source=thin, rows=rows))

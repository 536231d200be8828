"""FRFs that grow with every block, as messages for one viewer."""

from dataclasses import dataclass, field

import numpy as np

from modallab.core.frf import UNIT, Frf
from modallab.service.campaigns.live_samples import binary_message
from modallab.service.campaigns.runs import record_of
from modallab.service.context import Service
from modallab.service.errors import ConflictError


@dataclass(frozen=True, slots=True)
class FrfSelection:
    """What a viewer wants to see.

    Attributes:
        run: of this run.
        outputs: channel names; none for all.
        low_hz: lines from here.
        high_hz: up to here.
    """

    run: str
    outputs: tuple[str, ...]
    low_hz: float
    high_hz: float


@dataclass(eq=False, slots=True)
class FrfWatch:
    """One viewer of one run's FRFs.

    Attributes:
        service: that knows them.
        chosen: what is to be seen.
    """

    service: Service
    chosen: FrfSelection
    _known: bool = False
    _seen: dict[int | None, int] = field(default_factory=dict[int | None, int])

    def look(self) -> list[bytes]:
        """A message for each point whose FRF is another one than at the last look; none before the first block.

        Its array is (2, outputs, lines) complex64, mobility and coherence, the latter only where blocks are averaged.

        Raises:
            NotFoundError: there is no such run.
            DataError: there is no such output.
        """
        if not self._known:
            record_of(self.service, self.chosen.run)
            self._known = True
        try:
            self._seen, found = self.service.frfs().news(self.chosen.run, self.chosen.outputs, self._seen)
        except ConflictError:
            return []
        return [self._message(frf) for frf in found]

    def _message(self, frf: Frf) -> bytes:
        chosen = self.chosen
        band = (frf.frequency_hz >= chosen.low_hz) & (frf.frequency_hz <= chosen.high_hz)
        parts = [frf.values[:, 0, band].astype(np.complex64)]
        if frf.coherence is not None:
            parts.append(frf.coherence[:, 0, band].astype(np.complex64))
        lines = frf.frequency_hz[band]
        about: dict[str, object] = {
            "run": chosen.run,
            "quantity": frf.quantity,
            "unit": UNIT[frf.quantity],
            "input_point": frf.input_points[0],
            "averages": frf.averages[0],
            "outputs": list(frf.outputs),
            "output_points": list(frf.output_points),
            "coherence": frf.coherence is not None,
            "frequency_hz": _axis_of_lines(lines),
        }
        return binary_message(about, np.stack(parts))


def _axis_of_lines(lines: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> dict[str, float] | list[float]:
    """First line and step where the lines are evenly apart, else all of them."""
    step = (lines[-1] - lines[0]) / (lines.size - 1) if lines.size > 1 else 0.0
    if lines.size > 2 and np.allclose(np.diff(lines), step, rtol=1e-9):
        return {"first": float(lines[0]), "step": float(step), "count": float(lines.size)}
    return [float(line) for line in lines]

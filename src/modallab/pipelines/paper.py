"""Table 1 of the paper this project follows, and what explains each of its numbers.

Frequencies of beams on a root spring or with a tip mass: Blevins, Formulas for Dynamics, Acoustics and Vibration, 2016,
ch. 4; here by the twin's finite elements.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.digits import percent_text
from modallab.core.frozen import Frozen
from modallab.core.plan import BLOCK_S
from modallab.core.rig import Beam
from modallab.reporting.figures.damping import half_power_readings
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure

TABLE_1 = ((4.8, 0.1250), (30.9, 0.0385), (87.8, 0.0103))
"""Hz and damping of the three modes, as printed."""
LINE_HZ = 1 / BLOCK_S
DAMPING = (0.002, 0.005, 0.01, 0.02, 0.03)
"""Damping ratios a steel link in its clamp may have."""
HIT_S = 0.05
NEAR = 0.08
"""Lines by which what is printed with one digit may be off a line."""
SPRINGS = np.geomspace(1.0, 1e4, 400)
MASSES = np.geomspace(1e-4, 1.0, 400)
_BEAM = Beam(length_m=1.0, width_m=0.05, thickness_m=0.004, youngs_modulus_pa=2.05e11, density_kg_m3=7850.0)


class PaperMode(Frozen):
    """One row of Table 1.

    Attributes:
        printed_hz: frequency.
        printed_damping: damping, a share.
        line: nearest line of the block's spectrum.
        on_line: whether the frequency is that line's, but for rounding: then it was read off a spectrum.
        plain: (lowest, highest) damping ratio that half-power reads in a block of that length without a window, for any
            beam of 0.2 to 3 %.
        hann: the same under a Hann window.
        as_width: damping ratio if what is printed is the relative width of the peak.
    """

    printed_hz: float
    printed_damping: float
    line: int
    on_line: bool
    plain: tuple[float, float]
    hann: tuple[float, float]
    as_width: float


class BeamForTable(Frozen):
    """A beam that could have the frequencies of Table 1.

    Attributes:
        name: what is not ideal about it.
        best: the number that fits best: root spring in EI/L, or tip mass in masses of the beam; None: it has none.
        frequency_hz: its three frequencies.
        allowed: (low, high) within which all three stay within half a line of what is printed; None if none does.
        worst_lines: by how many lines it is off at worst.
    """

    name: str
    best: float | None
    frequency_hz: tuple[float, float, float]
    allowed: tuple[float, float] | None
    worst_lines: float


class PaperExplained(Frozen):
    """What explains Table 1.

    Attributes:
        line_hz: distance of the lines.
        modes: its rows.
        explanations: of its frequencies.
        apart_hz: largest difference between a frequency on the best root spring and one with the best tip mass.
        said: plain sentences.
    """

    line_hz: float
    modes: list[PaperMode]
    explanations: list[BeamForTable]
    apart_hz: float
    said: list[str]


def explain_paper() -> PaperExplained:
    """Explain Table 1 number by number."""
    modes = [_paper_mode(hz, damping) for hz, damping in TABLE_1]
    bare = TwinStructure.of(_BEAM, 0.006)
    rigid = _best_beam("an ideal clamp", lambda _: bare, None)
    spring = _best_beam("a root that turns", lambda k: replace(bare, root_rotation=1 / k), SPRINGS)
    mass = _best_beam("a mass at the tip", lambda m: replace(bare, masses=((1.0, m * _BEAM.mass_kg),)), MASSES)
    apart = float(np.max(np.abs(np.subtract(spring.frequency_hz, mass.frequency_hz))))
    listed = [rigid, spring, mass]
    return PaperExplained(
        line_hz=LINE_HZ, modes=modes, explanations=listed, apart_hz=apart, said=_modes_in_words(modes, listed, apart)
    )


def _paper_mode(hz: float, damping: float) -> PaperMode:
    line = round(hz / LINE_HZ)
    plain, hann = (half_power_readings(hz, np.array(DAMPING), BLOCK_S, HIT_S, hann=window) for window in (False, True))
    return PaperMode(
        printed_hz=hz,
        printed_damping=damping,
        line=line,
        on_line=abs(hz - line * LINE_HZ) < NEAR * LINE_HZ + 0.05,
        plain=(float(np.nanmin(plain)), float(np.nanmax(plain))),
        hann=(float(np.nanmin(hann)), float(np.nanmax(hann))),
        as_width=damping / 2,
    )


def _best_beam(name: str, of: Callable[[float], TwinStructure], sizes: Real | None) -> BeamForTable:
    """The size whose worst distance from Table 1 is least, EI over rho A free: it only scales all frequencies."""
    tried = sizes if sizes is not None else np.zeros(1)
    found = [_scale_frequencies(solve_modes(of(float(size))).frequency_hz[:3]) for size in tried]
    worst = np.array([off for _, off in found])
    best = int(np.argmin(worst))
    inside = tried[worst <= 0.5]
    return BeamForTable(
        name=name,
        best=None if sizes is None else float(tried[best]),
        frequency_hz=(found[best][0][0], found[best][0][1], found[best][0][2]),
        allowed=(float(inside.min()), float(inside.max())) if sizes is not None and len(inside) else None,
        worst_lines=float(worst[best]),
    )


def _scale_frequencies(own_hz: Real) -> tuple[list[float], float]:
    """The frequencies, scaled to be as near to Table 1 as can be, and their worst distance in lines."""
    printed = np.array([hz for hz, _ in TABLE_1])
    scales = np.linspace(0.9, 1.1, 2001)[:, None] * (printed[2] / own_hz[2])
    off = np.max(np.abs(scales * own_hz - printed), axis=1) / LINE_HZ
    k = int(np.argmin(off))
    return (scales[k] * own_hz).tolist(), float(off[k])


def _range_in_words(low: float, high: float) -> str:
    return f"{percent_text(low)} to {percent_text(high)}"


def _modes_in_words(modes: list[PaperMode], listed: list[BeamForTable], apart: float) -> list[str]:
    first, second, third = modes
    rigid, spring, mass = listed
    lines = [str(m.line) for m in modes if m.on_line]
    said = [
        f"A block of {BLOCK_S} s has lines {LINE_HZ:.3f} Hz apart: a frequency read off a peak is known to half of "
        f"that, {LINE_HZ / 2:.2f} Hz. Lines {' and '.join(lines)} are in the table.",
        f"Mode 1, {percent_text(first.printed_damping, 3)}: any beam of "
        f"{_range_in_words(DAMPING[0], DAMPING[-1])} reads "
        f"{_range_in_words(*first.plain)} in such a block without a window, and "
        f"{_range_in_words(*first.hann)} under a Hann window. As a "
        f"relative width it is a damping ratio of {percent_text(first.as_width, 3)}, as a damping ratio it is what the "
        "window leaves: both are the block, not the beam.",
        f"Of mode 2's {percent_text(second.printed_damping, 3)} and mode 3's "
        f"{percent_text(third.printed_damping, 3)} the block "
        f"alone makes {percent_text(second.plain[0])} and {percent_text(third.plain[0])}, under a Hann window "
        f"{percent_text(second.hann[0])} and {percent_text(third.hann[0])}: the rest may be that of the beam.",
        f"The frequencies' ratios are not those of an ideal clamp. A root spring of {spring.best:.3g} EI/L and a tip "
        f"mass of 1/{1 / (mass.best or 1):.0f} of the beam fit equally: their frequencies differ by {apart:.2g} Hz at "
        f"most, {apart / LINE_HZ:.2g} of a line. Frequencies alone cannot decide; shapes and residues can.",
    ]
    if rigid.worst_lines <= 0.5:
        said.append(
            f"Such lines cannot exclude the ideal clamp either: with EI over rho A free, its frequencies are within "
            f"{rigid.worst_lines:.2f} of a line of all three."
        )
    return said + [
        f"Within half a line of all three is {found.name}, {_allowed_range(*found.allowed, unit, above)}."
        for found, unit, above in ((spring, "EI/L", True), (mass, "of the beam", False))
        if found.allowed is not None
    ]


def _allowed_range(low: float, high: float, unit: str, above: bool) -> str:
    return f"{low:.2g} {unit} and stiffer" if above and high > 0.99 * SPRINGS[-1] else f"up to {high:.2g} {unit}"

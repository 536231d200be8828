"""How a structure behaves and what motion forces give, by its model, as tables: the same words at every door."""

import numpy as np

from modallab.core.digits import list_in_words, number_with_sigma, share_text
from modallab.core.units import SI_UNIT
from modallab.modification.deflection import Deflection
from modallab.modification.freedoms import Freedom
from modallab.modification.motion import MotionOverTime
from modallab.modification.nodes import AntinodesAndNodes
from modallab.modification.participation import ModalParticipation
from modallab.modification.structure import At
from modallab.reporting.modification_table import TableRows
from modallab.updating.correlation import ModelCorrelation
from modallab.verification.comparison import ModelReduction

MOST = 0.995
"""Of a mode's largest motion: as much as that is all of it, in whole percent."""
_PREFIXES = {1.0: "", 1e3: "m", 1e6: "µ", 1e9: "n"}


def participation_rows(found: ModalParticipation, frequency_hz: list[float]) -> TableRows:
    """Each mode's share of a response, with one standard deviation."""
    rows = [
        (
            str(r + 1),
            f"{hz:.5g}",
            number_with_sigma(100 * float(found.share[r]), 100 * float(found.share_sigma[r])),
            f"{100 * found.alone[r]:.3g}",
        )
        for r, hz in enumerate(frequency_hz)
    ]
    if found.band_hz is not None:
        rows.append(("outside the band", "", f"{100 * found.outside:.2g}", ""))
    over = _heading_of_shares(found)
    sentences = (
        f"{found.quantity.capitalize()} of point {_point_name(found.of)}, {over} at point "
        f"{_point_name(found.at)}. Shares add up to 100 %; a negative share reduces the motion. Alone: effective "
        "value of the mode alone, in percent of the total."
    )
    return TableRows(("mode", "frequency [Hz]", "share [%]", "alone [%]"), tuple(rows), sentences)


def _heading_of_shares(found: ModalParticipation) -> str:
    if found.after_s is not None:
        begin, end = found.after_s
        when = f"{begin:g} s" if begin == end else f"{begin:g} to {end:g} s"
        return f"{when} after a hit"
    low, high = found.band_hz or (0.0, 0.0)
    return f"{low:.5g} Hz under a force" if low == high else f"{low:.4g} to {high:.4g} Hz under an even force"


def reduction_rows(found: ModelReduction) -> TableRows:
    """The error of each measured pair, and the size of the FRFs and of the model."""
    rows = [
        (str(into or "?"), name if out is None else f"{name} at {out}", f"{100 * e:.2g}", f"{f:.4f}")
        for into, errors, fracs in zip(found.input_points, found.error.T, found.frac.T, strict=True)
        for name, out, e, f in zip(found.outputs, found.output_points, errors, fracs, strict=True)
    ]
    sentences = (
        f"{found.measured_numbers} numbers were measured, the model has {found.model_numbers}: a factor of "
        f"{found.measured_numbers / found.model_numbers:.3g}. Error: effective value of the difference between "
        "regenerated and measured mobility, divided by the effective value of the measured mobility."
    )
    return TableRows(("driven at", "output", "error [%]", "FRAC"), tuple(rows), sentences)


def node_rows(found: AntinodesAndNodes) -> TableRows:
    """Where each mode moves most, and where its nodes are."""
    headings = ("mode", "frequency [Hz]", "antinode", "points near a node")
    between = bool(found.crossings)
    rows: list[tuple[str, ...]] = []
    for r, hz in enumerate(found.frequency_hz):
        places = [number_with_sigma(float(c.place_m[0]), c.sigma_m) for c in found.crossings if c.mode == r]
        near = ", ".join(_freedom_name(found, f) for f in found.nodes[r]) or "none"
        own = (str(r + 1), f"{hz:.5g}", _freedom_name(found, found.antinode[r]), near)
        rows.append((*own, ", ".join(places) or "none") if between else own)
    if between:
        headings = (*headings, "nodes at x [m]")
    return TableRows(headings, tuple(rows), " ".join(advice_of(found)))


def advice_of(found: AntinodesAndNodes) -> list[str]:
    """Where to hit and where to mount, in sentences."""
    where, least = found.best_freedom
    how = "moves most" if least > MOST else f"has at least {100 * least:.0f} % of its largest motion"
    sentences = [f"Hit or mount a sensor at point {_freedom_name(found, where)}: each mode {how} there."]
    for r, near in enumerate(found.nodes):
        if near:
            points = f"point{'s' if len(near) > 1 else ''} {list_in_words([_freedom_name(found, f) for f in near])}"
            sentences.append(f"A hit or sensor at {points} misses mode {r + 1}.")
    return [*sentences, "Mount a part that must not disturb a mode at one of its nodes."]


def _freedom_name(found: AntinodesAndNodes, freedom: Freedom) -> str:
    several = len({f[0] for f in found.freedoms}) < len(found.freedoms)
    return f"{freedom[0]}{freedom[1]}" if several else str(freedom[0])


def _point_name(at: At) -> str:
    return f"{at[0]}{at[1]}" if isinstance(at, tuple) else str(at)


def deflection_rows(found: Deflection) -> TableRows:
    """Amplitude with one standard deviation, and phase, of every point."""
    rows = tuple(
        (name, number_with_sigma(float(abs(value)), float(sigma)), f"{np.degrees(np.angle(value)):.0f}")
        for name, value, sigma in zip(found.names, found.values, found.sigma, strict=True)
    )
    sentences = f"{found.what[0].upper()}{found.what[1:]}, {found.frequency_hz:.5g} Hz."
    return TableRows(("point", f"amplitude [{found.unit}]", "phase [°]"), rows, sentences)


def correlation_rows(found: ModelCorrelation) -> TableRows:
    """Pairs of modes of a test and of another model, with what they differ by."""
    headings = (
        "mode",
        "of the other",
        "frequency [Hz]",
        "other [Hz]",
        "difference [%]",
        "damping [%]",
        "other [%]",
        "MAC",
    )
    rows = tuple(_paired_mode_row(found, n) for n in range(len(found.pairs)))
    worst = int(np.argmin(found.comac))
    point, axis = found.freedoms[worst]
    sentences = [f"Lowest COMAC of {len(found.freedoms)} points: {found.comac[worst]:.3f} at point {point}{axis}."]
    for whose, modes in zip(("the first", "the other"), found.alone, strict=True):
        if modes:
            sentences.append(f"Modes of {whose} model alone: {', '.join(str(r + 1) for r in modes)}.")
    return TableRows(headings, rows, " ".join(sentences))


def _paired_mode_row(found: ModelCorrelation, n: int) -> tuple[str, ...]:
    i, j = found.pairs[n]
    hz, zeta = found.frequency_hz[n], 100 * found.damping_ratio[n]
    return (
        str(i + 1),
        str(j + 1),
        number_with_sigma(float(hz[0]), float(found.frequency_sigma_hz[n, 0])),
        f"{hz[1]:.5g}",
        f"{100 * (hz[1] / hz[0] - 1):+.2f}",
        number_with_sigma(float(zeta[0]), 100 * float(found.damping_sigma[n, 0])),
        f"{zeta[1]:.3g}",
        f"{found.mac[i, j]:.3f}",
    )


def motion_rows(motion: MotionOverTime) -> TableRows:
    """Largest value, effective value and octave bands of every point, the first two with one standard deviation."""
    factor = next((f for f in _PREFIXES if f * motion.peak.max() >= 1), 1.0)
    unit = _PREFIXES[factor] + SI_UNIT[motion.quantity]
    figures = zip(motion.names, factor * motion.figures, factor * motion.figures_sigma, strict=True)
    # Octave bands without their deviation fit a terminal; the document has it.
    rows = tuple(
        (
            name,
            *(number_with_sigma(float(v), float(s)) for v, s in zip(own[:2], sigma[:2], strict=True)),
            *(f"{v:.3g}" for v in own[2:]),
        )
        for name, own, sigma in figures
    )
    seconds = motion.values.shape[1] * motion.dt
    low, high = motion.band_hz
    caption = (
        f"{motion.quantity} in {unit} over {seconds:.4g} s; below each frequency in Hz, the rms of its octave."
        f" {share_text(motion.outside)} of the forces' power is outside {low:.4g} to {high:.4g} Hz, where the model is "
        "not valid."
    )
    return TableRows(("point", "peak", "rms", *(f"{centre:.3g}" for centre in motion.octaves_hz)), rows, caption)


def motion_document(motion: MotionOverTime) -> dict[str, object]:
    """The same for other programs, in SI units, all with one standard deviation."""
    figures = {"peak": 0, "rms": 1, "levels": slice(2, None)}
    values = {name: motion.figures[:, part].tolist() for name, part in figures.items()}
    sigmas = {f"{name}_sigma": motion.figures_sigma[:, part].tolist() for name, part in figures.items()}
    about = {"outside": motion.outside, "quantity": motion.quantity, "step_s": motion.dt, "points": list(motion.names)}
    return about | {"octaves_hz": np.round(motion.octaves_hz, 4).tolist()} | values | sigmas

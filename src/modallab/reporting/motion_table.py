"""The motion that forces give, as a table: the same words at every door."""

import numpy as np

from modallab.core.digits import number_with_sigma, part_of
from modallab.core.units import SI_UNIT
from modallab.modification.motion import MotionOverTime
from modallab.reporting.modified_table import TableRows

PREFIXES = {1.0: "", 1e3: "m", 1e6: "µ", 1e9: "n"}


def motion_rows(motion: MotionOverTime) -> TableRows:
    """Largest value, effective value and octave bands of every point, the first two with one standard deviation."""
    factor = next((f for f in PREFIXES if f * motion.peak.max() >= 1), 1.0)
    unit = PREFIXES[factor] + SI_UNIT[motion.quantity]
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
        f"{motion.quantity} in {unit} over {seconds:.4g} s; beneath a frequency in Hz, the rms of its octave."
        f" {part_of(motion.outside)} of the forces' power is outside {low:.4g} to {high:.4g} Hz, where the model says"
        " little."
    )
    return TableRows(("point", "peak", "rms", *(f"{centre:.3g}" for centre in motion.octaves_hz)), rows, caption)


def motion_document(motion: MotionOverTime) -> dict[str, object]:
    """The same for other programs, in SI units, all with one standard deviation."""
    figures = {"peak": 0, "rms": 1, "levels": slice(2, None)}
    values = {name: motion.figures[:, part].tolist() for name, part in figures.items()}
    sigmas = {f"{name}_sigma": motion.figures_sigma[:, part].tolist() for name, part in figures.items()}
    about = {"outside": motion.outside, "quantity": motion.quantity, "step_s": motion.dt, "points": list(motion.names)}
    return about | {"octaves_hz": np.round(motion.octaves_hz, 4).tolist()} | values | sigmas

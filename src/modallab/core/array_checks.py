"""Checks on arrays: what no measurement can hold is rejected before it turns into a number that looks right.

Each check raises one `DataError` that lists everything it found. They are meant for every border: files, and the
public functions that take arrays.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.axis_checks import check_frequencies, check_rate, check_time
from modallab.core.errors import DataError

__all__ = [
    "LARGEST",
    "check_frequencies",
    "check_frf",
    "check_rate",
    "check_samples",
    "check_signals",
    "check_spectra",
    "check_time",
    "identical_channels",
]

LARGEST = 1e30
"""No quantity on a bench is as large, in any unit: such a number comes from a damaged file."""


class _Finding(NamedTuple):
    what: str
    remedy: str


_TRANSPOSE = "transpose the array: one row per channel, one column per sample"
_RECORD_AGAIN = "check the recording there; leave this record out, or record it again"
_MEND = "check sensor, cable and input, and record again; or leave the channel out of both rig and recording"
_PHASE = "export the FRF as complex numbers (real and imaginary part)"
_ROUNDING = 1e-9
_HALF = "give the lines up to half of the sampling rate only"


def check_signals(
    samples: NDArray[Any],
    channels: Sequence[str],
    where: str = "",
    *,
    force: str | None = None,
) -> None:
    """Reject what no recording holds, and a record of which nothing can be made.

    Noise, clipping, a turned, swapped or dead response are no errors: they are what a diagnosis is for.

    Args:
        samples: (channels, n), counts or real numbers.
        channels: (channels,) names.
        where: file and record, for the message.
        force: name of the channel without which there is no FRF.

    Raises:
        DataError: as `check_samples`; or a dead force, or nothing but constants.
    """
    check_samples(samples, channels, where)
    _reject_findings(_nothing_recorded(samples, channels, force), where)


def check_samples(samples: NDArray[Any], channels: Sequence[str], where: str = "") -> None:
    """Reject what no recording holds; arguments as for `check_signals`.

    Raises:
        DataError: wrong shape or type, transposed, NaN or infinity.
    """
    _check_shape(samples, channels, where)
    _reject_findings(_not_finite(samples, channels), where)


def identical_channels(samples: NDArray[Any], channels: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Pairs of channels that agree in every bit, as copies do and sensors do not. Constant channels do not count."""
    first: dict[bytes, str] = {}
    pairs: list[tuple[str, str]] = []
    for name, row in zip(channels, samples, strict=True):
        if (row == row[0]).all():
            continue
        original = first.setdefault(row.tobytes(), name)
        if original != name:
            pairs.append((original, name))
    return tuple(pairs)


def check_frf(
    frequency_hz: NDArray[np.float64],
    values: NDArray[Any],
    outputs: Sequence[str],
    where: str = "",
    *,
    even: bool = True,
    resolution_hz: ArrayLike = 0.0,
) -> None:
    """Reject what no measured FRF holds.

    Args:
        frequency_hz: (lines,) in Hz.
        values: (outputs, inputs, lines) complex.
        outputs: (outputs,) channel names.
        where: file, for the message.
        even: as for `check_frequencies`.
        resolution_hz: as for `check_frequencies`.

    Raises:
        DataError: wrong frequencies or shape, NaN or infinity, an output without response, a missing phase.
    """
    check_frequencies(frequency_hz, where, even=even, resolution_hz=resolution_hz)
    if values.ndim != 3 or 0 in values.shape or values.shape[::2] != (len(outputs), len(frequency_hz)):
        expected = f"({len(outputs)} outputs, inputs, {len(frequency_hz)} lines)"
        raise DataError(f"the FRF has shape {values.shape}, not {expected}", where=where, remedy="reorder its axes")
    if np.iscomplexobj(values):
        findings = [f for name, frf in zip(outputs, values, strict=True) for f in _frf_findings(name, frf)]
    else:
        findings = [_Finding(f"the FRF is {_real_kind(values)}: its phase is missing", _PHASE)]
    _reject_findings(findings, where)


def _frf_findings(name: str, frf: NDArray[np.complex128]) -> list[_Finding]:
    if not _values_within(frf):
        bad = ~((np.abs(frf.real) <= LARGEST) & (np.abs(frf.imag) <= LARGEST))
        what = f"beyond {LARGEST:g}" if np.isfinite(frf).all() else "NaN or infinite"
        return [_Finding(f"channel {name}: {int(bad.sum())} lines of its FRF are {what}", _RECORD_AGAIN)]
    if not frf.any():
        return [_Finding(f"channel {name}: its FRF is zero at every line", _MEND)]
    # One line may be real by chance, as the line at 0 Hz is.
    if frf.shape[-1] > 1 and not frf.imag.any():
        return [_Finding(f"channel {name}: its FRF is {_real_kind(frf.real)}: the phase is missing", _PHASE)]
    if _mirrors_itself(frf) or _mirrors_itself(frf[:, 1:]):
        return [_Finding(f"channel {name}: the upper half of its FRF mirrors the lower, as over a whole FFT", _HALF)]
    return []


def _mirrors_itself(frf: NDArray[np.complex128]) -> bool:
    """Whether the upper half of the lines is the lower one, turned round and conjugated."""
    off = np.abs(frf - frf[:, ::-1].conj()).max(initial=0.0)
    return frf.shape[-1] > 2 and bool(off <= _ROUNDING * np.abs(frf).max())


def _values_within(frf: NDArray[np.complex128]) -> bool:
    # A largest and a smallest number show it without an array for every step; NaN compares as false.
    parts = np.ascontiguousarray(frf, np.complex128).view(np.float64)
    return float(parts.max()) <= LARGEST and float(parts.min()) >= -LARGEST


def _real_kind(values: NDArray[Any]) -> str:
    return "magnitude only (real, nowhere negative)" if (values >= 0).all() else "real at every line"


def _check_shape(samples: NDArray[Any], channels: Sequence[str], where: str) -> None:
    shape, expected = samples.shape, len(channels)
    if samples.dtype.kind not in "iuf":
        kind = "complex numbers, as a spectrum has" if samples.dtype.kind == "c" else f"values of type {samples.dtype}"
        raise DataError(f"the samples are {kind}", where=where, remedy="give the time record, as real numbers")
    if samples.size == 0:
        raise DataError("there are no samples", where=where, remedy="record again, or leave this record out")
    if samples.ndim != 2:
        raise DataError(f"the samples have shape {shape}", where=where, remedy="give an array (channels, samples)")
    if shape[0] > shape[1]:
        found = f"the samples have shape {shape}, more channels than samples: the array looks transposed"
        raise DataError(found, where=where, remedy=_TRANSPOSE)
    if shape[0] != expected:
        raise DataError(
            f"there are {shape[0]} channels, the rig has {expected}: {', '.join(channels)}",
            where=where,
            remedy="make rig and recording name the same channels, in the same order",
        )


def _not_finite(samples: NDArray[Any], channels: Sequence[str]) -> list[_Finding]:
    if samples.dtype.kind != "f":
        return []
    bad = ~(np.abs(samples) <= LARGEST)
    findings: list[_Finding] = []
    for i in map(int, np.flatnonzero(bad.any(axis=1))):
        what = f"beyond {LARGEST:g}" if np.isfinite(samples[i]).all() else "NaN or infinite"
        count, first = int(bad[i].sum()), int(bad[i].argmax())
        found = f"channel {channels[i]}: {count} of {bad.shape[1]} samples are {what}, the first is sample {first}"
        findings.append(_Finding(found, _RECORD_AGAIN))
    return findings


def _nothing_recorded(samples: NDArray[Any], channels: Sequence[str], force: str | None) -> list[_Finding]:
    constant = (samples == samples[:, :1]).all(axis=1)
    if constant.all():
        value = "zero" if not samples.any() else "constant"
        found = f"every channel is {value} ({', '.join(channels)}): nothing was recorded"
        return [_Finding(found, "check that the inputs are connected and switched on, and record again")]
    dead = [row for name, row, still in zip(channels, samples, constant, strict=True) if still and name == force]
    return [_Finding(f"channel {force} is dead: all {row.size} samples are {row[0] + 0:g}", _MEND) for row in dead]


def _reject_findings(findings: Sequence[_Finding], where: str) -> None:
    if findings:
        remedies = dict.fromkeys(finding.remedy for finding in findings)
        raise DataError("\n  ".join(f.what for f in findings), where=where, remedy="; ".join(remedies))


def check_spectra(force: NDArray[np.complex128], response: NDArray[np.complex128]) -> None:
    """Reject spectra of forces and responses that are not of the same blocks and lines, or not finite.

    Raises:
        DataError: names the shapes.
    """
    if force.ndim != 3 or response.ndim != 3 or force.shape[::2] != response.shape[::2] or 0 in response.shape:
        raise DataError(
            f"force {force.shape} and response {response.shape} do not belong together",
            remedy="give spectra (blocks, inputs, lines) of the forces and (blocks, outputs, lines) of the responses",
        )
    if not (np.isfinite(force).all() and np.isfinite(response).all()):
        raise DataError("the spectra hold NaN or infinite values", remedy="check the blocks of these spectra")

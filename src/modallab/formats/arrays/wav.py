"""WAV files: channels in rig order."""

import io
import struct
import warnings
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.arrays.named import ALL, RATE, campaign_of_arrays
from modallab.formats.options import ImportOptions

_OPEN = 0xFFFFFFFF
"""In place of a length: until the end."""


def read_wav(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record. Whole numbers are shares of full scale, from -1 to 1; a note says so.

    Raises:
        FormatError: no whole WAV file.
        DataError: not as many channels as the rig has.
    """
    try:
        with warnings.catch_warnings():
            # Chunks of other programs say nothing of the samples; one that ends early is an error.
            warnings.filterwarnings("ignore", message="Chunk")
            warnings.filterwarnings("error", message="Reached EOF")
            rate, samples = wavfile.read(_with_length(path) or path)
    except ValueError as error:
        if "Unknown wave file format" not in str(error):
            raise FormatError(
                f"is no whole WAV file: {error}", where=str(path), remedy="copy the file again"
            ) from error
        coded = f"holds samples in a code that is not linear: {str(error).partition(':')[2].strip()}"
        raise DataError(coded, where=str(path), remedy="convert it to PCM or to floating-point numbers") from error
    except (OSError, EOFError, wavfile.WavFileWarning) as error:
        raise FormatError(f"is no whole WAV file: {error}", where=str(path), remedy="copy the file again") from error
    note = ""
    if samples.dtype.kind in "iu":
        half = 2.0 ** (8 * samples.dtype.itemsize - 1)
        samples = (samples.astype(np.float64) - (half if samples.dtype.kind == "u" else 0.0)) / half
        unit = "V" if options.volts else "each channel's unit"
        note = f"{path.name}: whole numbers were taken as shares of full scale, and full scale as 1 {unit}"
    samples = samples.reshape(len(samples), -1)
    if samples.shape[1] != len(rig.channels):
        raise DataError(
            f"holds {samples.shape[1]} channels, and the rig names {len(rig.channels)}: "
            + ", ".join(c.name for c in rig.channels),
            where=str(path),
            remedy="name in the rig what each channel of the file is, in its order",
        )
    arrays = {ALL: samples, RATE: np.array(float(rate))}
    found = campaign_of_arrays(arrays, path.stem, rig, options, str(path))
    return Campaign(rig, found.blocks, provenance={"notes": note} if note else {}, source=str(path))


def _with_length(path: Path) -> io.BytesIO | None:
    """The file with the length of its samples, if that is left open, as by a program that streams; else None."""
    data, place = path.read_bytes(), 12
    if data[:4] == b"RF64":  # It says its lengths in a chunk of their own.
        return None
    while place + 8 <= len(data):
        name, size = data[place : place + 4], struct.unpack_from("<I", data, place + 4)[0]
        if name == b"data" and size == _OPEN:
            whole, own = (struct.pack("<I", len(data) - k - 8) for k in (0, place))
            return io.BytesIO(data[:4] + whole + data[8 : place + 4] + own + data[place + 8 :])
        place += 8 + size + size % 2
    return None

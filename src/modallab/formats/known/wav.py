"""WAV files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    return head[:4] in (b"RIFF", b"RIFX", b"RF64") and head[8:12] == b"WAVE"


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.arrays.wav import read_wav

    return read_wav(path, rig, options)


FORMAT = Format(
    name="wav",
    title="WAV",
    description="a sound file: channels in rig order",
    endings=(".wav",),
    is_no="WAV file",
    holds=("records",),
    asks=("test", "drive_point", "volts", "frequency_hz"),
    priority=6,
    fits=_fits,
    read=_read,
)

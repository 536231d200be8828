"""WAV files."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    return head[:4] in (b"RIFF", b"RIFX", b"RF64") and head[8:12] == b"WAVE"


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
    read=deferred("arrays.wav:read_wav"),
)

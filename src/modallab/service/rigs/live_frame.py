"""Live samples on the wire: a length, what they are as JSON, and the samples.

4 bytes   length of the JSON text, little-endian, unsigned
JSON      rig, run, first_sample, rate_hz, channels, scale, units, dtype, shape
samples   (channels, n), C order, little-endian
"""

import json
import struct

from modallab.acquisition.monitor.live import LiveSamples


def frame(rig: str, live: LiveSamples) -> bytes:
    """One binary message."""
    samples = live.samples.astype(live.samples.dtype.newbyteorder("<"), copy=False)
    about = {
        "rig": rig,
        "run": live.run,
        "first_sample": live.first_sample,
        "rate_hz": live.rate_hz,
        "channels": live.channels,
        "scale": live.scale,
        "units": live.units,
        "dtype": samples.dtype.str,
        "shape": samples.shape,
    }
    text = json.dumps(about).encode()
    return struct.pack("<I", len(text)) + text + samples.tobytes()

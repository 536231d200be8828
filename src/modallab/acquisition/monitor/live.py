"""What the bench delivers, shown while it comes: for a look, never for the record.

Live samples on the wire are a length, what they are as JSON, and the samples:

4 bytes   length of the JSON text, little-endian, unsigned
JSON      rig, run, first_sample, rate_hz, channels, scale, units, dtype, shape
samples   (channels, n), C order, little-endian
"""

import json
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Chunk, Delivery

EVERY_S = 0.04
"""No more often than this; where time is virtual most of what comes is left out, which `first_sample` shows."""


@dataclass(frozen=True, eq=False, slots=True)
class LiveSamples:
    """A stretch as the device delivered it.

    Attributes:
        run: the run it belongs to.
        first_sample: place of the first sample in the device's count since the run's start.
        rate_hz: of the device.
        channels: names, rig order.
        scale: (channels,) unit per count.
        units: (channels,).
        samples: (channels, n).
    """

    run: str
    first_sample: int
    rate_hz: float
    channels: tuple[str, ...]
    scale: tuple[float, ...]
    units: tuple[str, ...]
    samples: NDArray[np.generic]


class LiveTap:
    """Looks at every chunk and passes some on."""

    def __init__(
        self, run: str, channels: tuple[str, ...], delivery: Delivery, send: Callable[[LiveSamples], None]
    ) -> None:
        self._run = run
        self._channels = channels
        self._delivery = delivery
        self._send = send
        self._sent_s = float("-inf")

    def __call__(self, chunk: Chunk) -> None:
        """Pass a chunk on, if it is time."""
        now = time.monotonic()
        if now - self._sent_s < EVERY_S:
            return
        self._sent_s = now
        delivery = self._delivery
        scale = tuple(float(value) for value in delivery.scale)
        self._send(
            LiveSamples(
                self._run,
                chunk.first_sample,
                delivery.rate_hz,
                self._channels,
                scale,
                delivery.units,
                np.ascontiguousarray(chunk.samples),
            )
        )


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

"""A recorded campaign as a device: `replay://folder?speed=0`.

What was recorded is played, and nothing else: between two blocks there are no samples, so a read that would cross the
end of a block says that samples are lost, and the next one goes on with the next block.
"""

import time
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, unquote

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import AcquisitionRequest, Bench, BenchInfo, DeliveredSampling, SampleChunk
from modallab.core.block import Block, Campaign
from modallab.core.errors import (
    BenchTimeoutError,
    ConfigurationError,
    DeviceGoneError,
    SamplesLostError,
)
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab_drivers.output import NoOutput, require_count

_RATE_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False, slots=True)
class RecordedStretch:
    """A recorded block and its place in the replay's sample count."""

    first: int
    block: Block

    @property
    def end(self) -> int:
        """The sample after its last."""
        return self.first + self.block.n_samples


def open_bench(url: str, rig: Rig) -> Bench:
    """Open a campaign for replay; `speed` is 1 for real time (default), 2 for twice as fast, 0 for as fast as it goes.

    Raises:
        ConfigurationError: the address is not understood, or the campaign is of another rig.
        DeviceGoneError: there is no campaign.
        FormatError: the file is no campaign, or damaged.
    """
    path, speed = _parse(url)
    if not path.exists():
        raise DeviceGoneError(f"there is no recording at {path}", where=url, remedy="name a folder with campaign.h5")
    campaign = read_campaign(path)
    _same_channels(campaign.rig, rig, url)
    return ReplayBench(url, rig, campaign, speed)


class ReplayBench(NoOutput):
    """The blocks of one campaign, one test at a time."""

    _no_output = "a replay has no output", "use a bench with an output, or read the recorded sine test"

    def __init__(self, url: str, rig: Rig, campaign: Campaign, speed: float) -> None:
        self._url, self._rig, self._campaign, self._speed = url, rig, campaign, speed
        self._state = "open"
        self._stretches: tuple[RecordedStretch, ...] = ()
        self._at = self._position = 0
        tests = {test: len(campaign.of(test)) for test in ("impact", "sine")}
        facts = {f"recorded {key}": value for key, value in campaign.provenance.items()}
        self._info = BenchInfo(
            url,
            (("replay", campaign.source),),
            can_drive=False,
            real_time=speed > 0,
            facts=facts | {f"{test} blocks": str(count) for test, count in tests.items()},
        )

    @property
    def info(self) -> BenchInfo:
        """What was recorded, with its provenance as facts."""
        return self._info

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """Choose the test to play; the rate is the one of the recording."""
        self._require("open", "configured", "stopped", to="configure")
        blocks = self._campaign.of(request.test)
        if not blocks:
            raise ConfigurationError(
                f"the recording has no {request.test} test", where=self._url, remedy="replay the test it has"
            )
        first = blocks[0]
        _uniform(blocks, self._url)
        if not isfinite(request.rate_hz) or abs(request.rate_hz / first.rate_hz - 1) > _RATE_ROUNDING:
            raise ConfigurationError(
                f"the rate is {request.rate_hz:g} Hz, the recording's is {first.rate_hz:g} Hz",
                where=self._url,
                remedy=f"ask for {first.rate_hz:g} Hz",
            )
        self._stretches = _placed(blocks)
        self._state = "configured"
        actual = first.actual_rate_hz or first.rate_hz
        return DeliveredSampling(
            request.rate_hz, actual, first.rate_hz, first.samples.dtype, np.array(first.scale), first.units
        )

    def start(self) -> None:
        """Begin with the first block."""
        self._require("configured", "stopped", to="start")
        if not self._stretches:
            raise ConfigurationError("no test was chosen", where=self._url, remedy="configure first")
        self._at = self._position = 0
        self._began_s = time.monotonic()
        self._state = "running"

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """The next `count` samples of the block that is on."""
        self._require("running", to="read")
        require_count(count, self._url)
        if self._at == len(self._stretches):
            raise BenchTimeoutError("the recording has ended", where=self._url, remedy="stop, and start it again")
        stretch = self._stretches[self._at]
        left = stretch.end - self._position
        if count > left:
            raise self._lost(stretch, left)
        self._wait(count, timeout_s, stretch.block.rate_hz)
        begin = self._position - stretch.first
        samples: NDArray[Any] = stretch.block.samples[:, begin : begin + count].copy()
        chunk = SampleChunk(self._position, samples, _overload(stretch.block, samples))
        self._position += count
        if self._position == stretch.end:
            self._next()
        return chunk

    def stop(self) -> None:
        """Stop playing."""
        if self._state == "running":
            self._state = "stopped"

    def close(self) -> None:
        """Let go of the recording."""
        self._state = "closed"

    def _next(self) -> None:
        self._at += 1
        if self._at < len(self._stretches):
            self._position = self._stretches[self._at].first

    def _lost(self, stretch: RecordedStretch, left: int) -> SamplesLostError:
        self._next()
        follows = "the recording ends there" if self._at == len(self._stretches) else f"{self._position} comes next"
        return SamplesLostError(
            f"block {stretch.block.name} ends at sample {stretch.end}, {left} samples ahead; {follows}",
            where=self._url,
            remedy="read no further than a block's end; what follows is another stretch",
        )

    def _wait(self, count: int, timeout_s: float, rate_hz: float) -> None:
        if self._speed == 0:
            return
        due_s = self._began_s + (self._position + count) / (rate_hz * self._speed) - time.monotonic()
        if due_s > timeout_s:
            time.sleep(max(timeout_s, 0.0))
            raise BenchTimeoutError(
                f"{count} samples take {due_s:.3f} s, the time allowed is {timeout_s:g} s",
                where=self._url,
                remedy="read fewer samples, or wait longer; nothing is lost",
            )
        time.sleep(max(due_s, 0.0))


def _parse(url: str) -> tuple[Path, float]:
    _, _, rest = url.partition("://")
    path, _, query = rest.partition("?")
    given = dict(parse_qsl(query, keep_blank_values=True))
    unknown = sorted(set(given) - {"speed"})
    if not path or unknown:
        raise ConfigurationError(
            f"unknown parameter {', '.join(unknown)}" if unknown else "no folder is named",
            where=url,
            remedy="write replay://folder?speed=1",
        )
    text = given.get("speed", "1")
    try:
        speed = float(text)
    except ValueError:
        speed = -1.0
    if not 0 <= speed < inf:
        raise ConfigurationError(f"speed is {text!r}", where=url, remedy="allowed: 0 (as fast as it goes) or more")
    return Path(unquote(path)), speed


def _same_channels(recorded: Rig, rig: Rig, url: str) -> None:
    had, expected = [c.name for c in recorded.channels], [c.name for c in rig.channels]
    if had != expected:
        raise ConfigurationError(
            f"the recording's channels are {', '.join(had)}; the rig's are {', '.join(expected)}",
            where=f"{url}, rig file field channels",
            remedy="replay it with the rig it was recorded on",
        )


def _uniform(blocks: tuple[Block, ...], url: str) -> None:
    first = blocks[0]
    for block in blocks[1:]:
        same = block.rate_hz == first.rate_hz and block.samples.dtype == first.samples.dtype
        if not same or block.units != first.units or not np.array_equal(block.scale, first.scale):
            raise ConfigurationError(
                f"block {block.name} differs from {first.name} in rate, type, scale or unit",
                where=url,
                remedy="replay a campaign recorded with one configuration a test",
            )


def _placed(blocks: tuple[Block, ...]) -> tuple[RecordedStretch, ...]:
    """Each block at the place its device counted; one that begins before the last has ended comes a sample after it."""
    placed: list[RecordedStretch] = []
    offset = -blocks[0].first_sample
    for block in blocks:
        first = block.first_sample + offset
        if placed and first < placed[-1].end:
            # Another run, or a source that counted nothing: how long the pause was is not known.
            first = placed[-1].end + 1
            offset = first - block.first_sample
        placed.append(RecordedStretch(first, block))
    return tuple(placed)


def _overload(block: Block, samples: NDArray[Any]) -> NDArray[np.bool_]:
    flags = np.zeros(len(block.channels), dtype=np.bool_)
    if samples.dtype.kind == "i":
        info = np.iinfo(samples.dtype)
        flags |= np.any((samples == info.max) | (samples == info.min), axis=1)
    return flags if block.overload is None else flags | np.array(block.overload, dtype=np.bool_)

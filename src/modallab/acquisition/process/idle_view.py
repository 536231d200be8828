"""What the channels read while no run is on: shown for as long as somebody looks, and never recorded."""

import time
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from modallab.acquisition.monitor.live import FOLDER, IDLE, LiveRingBuffer
from modallab.bench.protocol import AcquisitionRequest, Bench
from modallab.core.errors import ModallabError
from modallab.core.rig import Rig

RATE_HZ = 2000.0
CHUNK_S = 0.05
SLACK_S = 5.0
LEFT_S = 3.0
"""Who looks says so again within this time."""
AGAIN_S = 2.0
"""Between two tries where the device does not deliver."""


def idle_ring_buffer_name(url: str) -> str:
    """Under which the signals of the bench at an address are shown while no run is on."""
    return f"{IDLE}{sha256(url.encode()).hexdigest()[:16]}"


def request_idle_view(data_folder: Path, name: str) -> None:
    """Say that somebody looks, or still does."""
    file = _request_file(data_folder, name)
    with suppress(OSError):
        file.parent.mkdir(exist_ok=True)
        file.write_text(str(time.monotonic_ns()), encoding="ascii")


class IdleView:
    """Shows the channels of an open bench. The output stays at 0 V."""

    def __init__(self, bench: Bench, rig: Rig, data_folder: Path) -> None:
        self._bench, self._rig, self._folder = bench, rig, data_folder
        self._name = idle_ring_buffer_name(bench.info.url)
        # What one who is gone has left there says nothing.
        self._request = self._look()
        self._request_s = float("-inf")
        self._not_before_s = float("-inf")

    @property
    def is_wanted(self) -> bool:
        """Whether somebody looks."""
        request, now = self._look(), time.monotonic()
        if request != self._request:
            self._request, self._request_s = request, now
        return now - self._request_s < LEFT_S and now > self._not_before_s

    def show(self, ended: Callable[[], bool]) -> None:
        """Until `ended`, or nobody looks any more."""
        try:
            self._show(ended)
        except ModallabError:
            # A run says better what is wrong with the device.
            self._not_before_s = time.monotonic() + AGAIN_S

    def _show(self, ended: Callable[[], bool]) -> None:
        bench = self._bench
        delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
        chunk = max(1, round(CHUNK_S * delivery.rate_hz))
        with LiveRingBuffer(self._folder) as live:
            tap = live.open(self._name, self._rig, delivery)
            bench.start()
            try:
                while self.is_wanted and not ended():
                    tap(bench.read(chunk, CHUNK_S + SLACK_S))
                    if not bench.info.real_time:
                        time.sleep(CHUNK_S)
            finally:
                bench.stop()

    def _look(self) -> str:
        try:
            return _request_file(self._folder, self._name).read_text(encoding="ascii")
        except (OSError, UnicodeError):
            return ""


def _request_file(data_folder: Path, name: str) -> Path:
    return data_folder / FOLDER / f"{name}.wanted"

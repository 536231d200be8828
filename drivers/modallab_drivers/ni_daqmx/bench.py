"""NI devices behind the bench protocol."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from math import isfinite
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.bench.capabilities import ReferenceTrigger, SyncState
from modallab.bench.protocol import AcquisitionRequest, BenchInfo, Burst, DeliveredSampling, SampleChunk, Waveform
from modallab.core.errors import BenchError, ConfigurationError, DeviceGoneError, SamplesLostError
from modallab.core.rig import Rig
from modallab_drivers.ni_daqmx.channels import teds_sensitivities, teds_serials
from modallab_drivers.ni_daqmx.errors import WatchdogExpiredError
from modallab_drivers.ni_daqmx.inputs import Inputs, TriggeredRecord
from modallab_drivers.ni_daqmx.plugs import Plug, plugs_of
from modallab_drivers.ni_daqmx.route import Route, parse_address, retry_while_reserved
from modallab_drivers.ni_daqmx.shaker import ShakerOutput
from modallab_drivers.output import require, require_count

State = Literal["open", "configured", "running", "armed", "stopped", "lost", "gone", "closed"]

MOST_COERCED = 2.0
"""A device that gives more than so many times the requested rate cannot do what was asked."""

FULL_SCALE = 1 - 1e-6


class NiBench:
    """Inputs of one device or chassis or of several, and what drives the shaker: an output of it, or a generator."""

    def __init__(self, url: str, rig: Rig) -> None:
        """Find the devices, check the rig against them, and bring the output to 0 V."""
        self._url, self._rig = url, rig
        self._address = parse_address(url)
        self._route = Route(self._address)
        self._inputs: Inputs | None = None
        self._state: State = "open"
        self._position = 0
        self._request: AcquisitionRequest | None = None
        self._record: TriggeredRecord | None = None
        devices = self._route.devices()
        self._plugs: tuple[Plug, ...] = plugs_of(rig, devices, url)
        self._shaker = ShakerOutput(self._route, rig, devices, url)
        self._info = BenchInfo(
            url,
            tuple((f"{device.product} {device.name}", device.serial) for device in devices),
            can_drive=self._shaker.can_drive,
            real_time=not self._address.virtual_time,
            facts={f"input of {p.channel.name}": p.physical for p in self._plugs}
            | ({"output": ", ".join(self._shaker.physical)} if self._shaker.physical else {})
            | ({"generator": self._shaker.identity} if self._shaker.identity else {}),
            streams_bursts=self._shaker.streams,
        )

    @property
    def info(self) -> BenchInfo:
        """What answers, and what is plugged into what."""
        return self._info

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """Make the input task. A rate the device can't give becomes the next one it can, which is said."""
        self._require("open", "configured", "stopped", "lost", "gone", to="configure")
        if not isfinite(request.rate_hz) or request.rate_hz <= 0:
            raise ConfigurationError(f"rate_hz is {request.rate_hz}", where=self._url, remedy="give a rate above 0")
        self._reconnect()
        self._drop_inputs()
        self._request = request
        inputs = self._make_inputs()
        if inputs.rate_hz > MOST_COERCED * request.rate_hz or inputs.rate_hz < request.rate_hz * (1 - 1e-9):
            given = inputs.rate_hz
            self._drop_inputs()
            raise ConfigurationError(
                f"rate_hz: {request.rate_hz:g} Hz was requested, the device gives {given:.6g} Hz",
                where=self._url,
                remedy=f"ask for {given / MOST_COERCED:.6g} Hz or more",
            )
        self._state = "configured"
        return DeliveredSampling(
            request.rate_hz,
            inputs.rate_hz,
            inputs.rate_hz,
            np.dtype(np.float32),
            inputs.volts_per_unit.copy(),
            ("V",) * len(self._plugs),
        )

    def start(self) -> None:
        """Start streaming; after a loss with a new task."""
        self._require("configured", "stopped", "lost", "gone", to="start")
        if self._request is None:
            raise ConfigurationError("no rate was chosen", where=self._url, remedy="configure first")
        if self._state in ("lost", "gone"):
            self._reconnect()
            self._drop_inputs()
        if self._shaker.has_watchdog:
            # It comes before anything that is reserved on its chassis, and inputs that feed sensors are.
            self._drop_inputs()
        self._shaker.watch(self._route)
        inputs = self._inputs or self._make_inputs()
        self._shaker.follow(inputs.reference_clock)
        try:
            retry_while_reserved(inputs.start)
        except BenchError as error:
            self._shaker.unwatch()
            if isinstance(error, DeviceGoneError):
                self._gone()
            raise
        self._position = 0
        self._state = "running"

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """The next `count` samples; between pieces of them the output is looked after."""
        self._require("running", to="read")
        require_count(count, self._url)
        assert self._inputs is not None
        first = self._position
        pieces: list[NDArray[np.float32]] = []
        with self._losses():
            while (left := first + count - self._position) > 0:
                piece = self._shaker.up_to_event(self._position, left)
                pieces.append(self._inputs.read(piece, timeout_s))
                self._position += pieces[-1].shape[1]
                self._shaker.check_output(self._position)
            samples = pieces[0] if len(pieces) == 1 else np.concatenate(pieces, axis=1)
            self._inputs.require_sensors()
            return SampleChunk(first, samples, self._at_full_scale(samples) | self._inputs.overloaded())

    def arm(self, trigger: ReferenceTrigger) -> None:
        """Let the device wait for a crossing."""
        self._require("configured", "stopped", to="arm")
        self._drop_inputs()
        inputs = self._make_inputs(trigger)
        try:
            retry_while_reserved(inputs.start)
        except DeviceGoneError:
            self._gone()
            raise
        self._record = TriggeredRecord(inputs, trigger, virtual_time=self._address.virtual_time)
        self._state = "armed"

    def is_armed(self) -> bool:
        """Whether the pre-trigger is full."""
        self._require("armed", to="ask for the trigger")
        assert self._record is not None
        with self._losses():
            return self._record.is_armed()

    def triggered(self, timeout_s: float) -> SampleChunk:
        """The record about the crossing."""
        self._require("armed", to="read a record")
        assert self._record is not None
        assert self._inputs is not None
        with self._losses():
            samples = self._record.take(timeout_s)
            return SampleChunk(0, samples, self._at_full_scale(samples) | self._inputs.overloaded())

    def play(self, burst: Burst) -> int:
        """Start a burst; the place of its rise counts the converter's own delay."""
        self._require("running", to="play")
        assert self._inputs is not None
        with self._losses():
            self._shaker.play(burst, self._position, self._inputs.rate_hz)
        start = max(self._inputs.acquired(), self._position)
        return start + round(self._inputs.delay_s * self._inputs.rate_hz)

    def play_wave(self, wave: Waveform) -> int:
        """Start a wave on the first output; as `play_waves`."""
        return self.play_waves([wave])

    def play_waves(self, waves: Sequence[Waveform]) -> int:
        """Start a wave on each output; the place of their beginning counts the converter's own delay."""
        self._require("running", to="play")
        assert self._inputs is not None
        with self._losses():
            self._shaker.play_waves(waves, self._position, self._inputs.rate_hz)
        start = max(self._inputs.acquired(), self._position)
        return start + round(self._inputs.delay_s * self._inputs.rate_hz)

    def output_facts(self) -> dict[str, float | str]:
        """What the generator took, looked at now."""
        return self._shaker.output_facts()

    def prompt_hit(self, point: int) -> None:
        """Whoever strikes is notified by the page; the point must be one of the rig."""
        self._rig.x_of(point)

    def supplied_channels(self) -> tuple[str, ...]:
        """Channels of the rig whose sensors the inputs feed with a current."""
        return tuple(plug.channel.name for plug in self._plugs if plug.supply_a)

    def synchronisation(self) -> SyncState:
        """How several devices sample as one, and how far each has counted."""
        self._require("configured", "running", "stopped", to="ask for the synchronisation")
        return (self._inputs or self._make_inputs()).synchronisation(running=self._state == "running")

    def read_sensitivities(self) -> dict[str, float]:
        """V per SI unit of the sensors that carry a TEDS, by channel."""
        self._require("open", "configured", "stopped", "lost", to="ask sensors")
        return teds_sensitivities(self._route, self._plugs)

    def channels_without_open_detection(self) -> tuple[str, ...]:
        """Names of fed channels of which the device cannot say whether a sensor is there."""
        return self._inputs.open_unseen() if self._inputs is not None else ()

    def read_serials(self) -> dict[str, str]:
        """Serial number of the sensors that carry a TEDS, by channel."""
        self._require("open", "configured", "stopped", "lost", to="ask sensors")
        return teds_serials(self._route, self._plugs)

    def zero(self) -> None:
        """Bring the output to 0 V now."""
        self._shaker.zero(reachable=self._state not in ("closed", "gone"))

    def stop(self) -> None:
        """Stop streaming, with the output at 0 V."""
        if self._state == "armed":
            self._record = None
            self._drop_inputs()
            self._state = "stopped"
        elif self._state in ("running", "lost"):
            self.zero()
            self._shaker.unwatch()
            if self._state == "running" and self._inputs is not None:
                self._inputs.stop()
            self._state = "stopped" if self._state == "running" else "lost"

    def close(self) -> None:
        """Release the devices, with the output at 0 V."""
        if self._state == "closed":
            return
        try:
            self._shaker.release_output(reachable=self._state != "gone")
        finally:
            self._shaker.unwatch()
            self._drop_inputs()
            self._route.close()
            self._state = "closed"

    def _require(self, *legal: State, to: str) -> None:
        require(self._state, *legal, to=to, where=self._url)

    @contextmanager
    def _losses(self) -> Generator[None]:
        # What the device says while it samples decides what may follow.
        try:
            yield
        except SamplesLostError:
            self._state = "lost"
            raise
        except WatchdogExpiredError as error:
            self._state = "lost"
            if self._shaker.driving(self._position):
                raise
            raise SamplesLostError(error.what, where=error.where, remedy=error.remedy) from error
        except DeviceGoneError:
            self._gone()
            raise

    def _make_inputs(self, reference: ReferenceTrigger | None = None) -> Inputs:
        request = self._request
        assert request is not None
        try:
            self._inputs = retry_while_reserved(lambda: self._inputs_for(request, reference))
        except DeviceGoneError:
            self._gone()
            raise
        return self._inputs

    def _inputs_for(self, request: AcquisitionRequest, reference: ReferenceTrigger | None) -> Inputs:
        return Inputs(self._route, self._plugs, request.test, request.rate_hz, reference, self._rig.synchronisation)

    def _at_full_scale(self, samples: NDArray[np.float32]) -> NDArray[np.bool_]:
        # Clipping is looked for here, before anything resamples; in volts, whatever the unit.
        assert self._inputs is not None
        peak = np.maximum(samples.max(axis=1), -samples.min(axis=1)) * self._inputs.volts_per_unit
        return peak >= np.array([plug.range_v for plug in self._plugs]) * FULL_SCALE

    def _gone(self) -> None:
        self._state = "gone"
        self._shaker.on_device_lost()

    def _reconnect(self) -> None:
        if self._state != "gone":
            return
        self._route.close()
        self._route = Route(self._address)
        self._shaker.reconnect(self._route, self._route.devices())
        self._inputs = None
        self._state = "stopped"

    def _drop_inputs(self) -> None:
        if self._inputs is not None:
            self._inputs.close()
            self._inputs = None

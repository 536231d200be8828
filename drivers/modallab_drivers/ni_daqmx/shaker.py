"""What drives the shakers of an NI bench, outputs of the device or a generator, and the guards that watch them."""

from collections.abc import Sequence

from modallab.bench.protocol import Burst, Waveform
from modallab.core.errors import BenchError, ConfigurationError, DeviceBusyError, UnsupportedError
from modallab.core.hardware import require_guarded
from modallab.core.rig import Rig
from modallab_drivers.function_generator.generator import Generator, open_generator
from modallab_drivers.ni_daqmx.analog_output import AnalogOutput
from modallab_drivers.ni_daqmx.guards import Guards, Watchdog, call_after_reset
from modallab_drivers.ni_daqmx.plugs import outputs_of
from modallab_drivers.ni_daqmx.route import DeviceInfo, Route
from modallab_drivers.output import Output, require_alike, require_burst, require_wave

PROBE_S = 10.0
"""Of a watchdog that is made only to see whether there is one."""


class ShakerOutput:
    """The excitation of one bench; a rig may have none, and then nothing can be played.

    Attributes:
        physical: the analog outputs, one for each shaker; none where a generator drives, or nothing.
    """

    def __init__(self, route: Route, rig: Rig, devices: Sequence[DeviceInfo], where: str) -> None:
        """Take the output, bring it to 0 V, and see that the guards the rig asks for can be had.

        Raises:
            BenchError: another program holds the output, or a guard can't be had.
        """
        self._rig, self._where = rig, where
        self._burst_end = 0
        self._output: Output | None = None
        self._guards = Guards(route, None, ())
        chosen = outputs_of(rig, devices, where)
        self.physical = tuple(name for name, _ in chosen)
        self._streams = bool(chosen) and route.address.streams
        self._guarded = not self._streams or (rig.excitation is not None and rig.excitation.watchdog_s is not None)
        if chosen:
            self._output = AnalogOutput(route, chosen, guarded=self._guarded)
        elif rig.shaker_point is not None and rig.excitation is not None and rig.excitation.kind == "generator":
            self._output = open_generator(rig)
        try:
            # Made once to see that the rig's fields are right; they watch from start to stop.
            self.watch(route)
            self.unwatch()
            self._require_no_needless_waiver(route)
        except BenchError:
            self.release_output()
            raise

    @property
    def can_drive(self) -> bool:
        """Whether there is an output."""
        return self._output is not None

    @property
    def streams(self) -> bool:
        """Whether a burst ends midway, and the output holds its last value, when this process dies."""
        return self._streams

    @property
    def has_watchdog(self) -> bool:
        """Whether the device's watchdog is used."""
        excitation = self._rig.excitation
        return bool(self.physical) and excitation is not None and excitation.watchdog_s is not None

    def driving(self, now: int) -> bool:
        """Whether a burst may be on at sample `now`."""
        return now < self._burst_end

    def watch(self, route: Route) -> None:
        """Streaming is about to begin: no burst is on, and the guards watch, before any other task is started."""
        self._guards.close()
        self._guards = call_after_reset(route, lambda: Guards(route, self._rig.excitation, self.physical))
        self._burst_end = 0

    def follow(self, reference_clock: str) -> None:
        """An output of the device runs by the clock that the inputs follow; by its own where there is none."""
        if isinstance(self._output, AnalogOutput):
            self._output.reference_clock = reference_clock

    def unwatch(self) -> None:
        """Streaming ends: the guards too."""
        self._guards.close()

    def play(self, burst: Burst, now: int, rate_hz: float) -> None:
        """Start a burst at sample `now`.

        Raises:
            UnsupportedError: there is no output.
            ConfigurationError: a burst is still on.
            BenchError: beyond the rig's limits or the output's range.
            WatchdogExpiredError: the device must be reset first.
        """
        if self._output is None:
            raise UnsupportedError(
                "there is no excitation output",
                where=self._where,
                remedy="give the rig a shaker_point and an excitation",
            )
        require_burst(burst, rate_hz, self._output.range_v, self._rig.limits, self._where)
        self._require_ready(self._output)
        self._output.play(burst, now, rate_hz)
        self._burst_end = now + round(burst.duration_s * rate_hz)

    def play_waves(self, waves: Sequence[Waveform], now: int, rate_hz: float) -> None:
        """Start waves of one rate and length at sample `now`, the first shaker's first.

        Raises:
            UnsupportedError: there is no analog output, or there are fewer than waves.
            ConfigurationError: something is still on, or a wave is beyond the rig's limits or the outputs' range.
        """
        if not isinstance(self._output, AnalogOutput):
            raise UnsupportedError(
                "there is no analog output, and a sine generator plays no waves",
                where=self._where,
                remedy="drive by an analog output of the device, or run a sine test",
            )
        if len(waves) > self._output.count:
            raise UnsupportedError(
                f"{len(waves)} waves for {self._output.count} outputs",
                where=self._where,
                remedy="list every shaker in the rig file, under shakers",
            )
        require_alike(waves, self._where)
        for wave in waves:
            require_wave(wave, self._output.range_v, self._rig.limits, self._where)
        self._require_ready(self._output)
        self._output.play_waves(waves)
        self._burst_end = now + round(waves[0].duration_s * rate_hz)

    def _require_ready(self, output: Output) -> None:
        if output.busy:
            raise ConfigurationError("a burst is still on", where=self._where, remedy="wait for it, or call zero()")
        if self._streams:
            require_guarded(self._rig.excitation, self._where)
        self._guards.beat(now=True)

    def up_to_event(self, now: int, count: int) -> int:
        """So many of the next `count` samples may be read before it must be looked after."""
        event = self._output.next_event() if self._output is not None else None
        return count if event is None else max(1, min(count, event - now))

    def check_output(self, now: int) -> None:
        """Between pieces of what is read."""
        self._guards.beat()
        if self._output is not None:
            self._output.tick(now)

    def zero(self, *, reachable: bool = True) -> None:
        """Bring the output to 0 V now; of a device that is gone, forget the burst."""
        self._burst_end = 0
        # A generator has a line of its own, which lives on without the device.
        if self._output is not None and (reachable or isinstance(self._output, Generator)):
            self._output.zero()

    def output_facts(self) -> dict[str, float | str]:
        """What a generator took of what it was set to, looked at now; raises as its `facts`."""
        return self._output.facts() if isinstance(self._output, Generator) else {}

    @property
    def identity(self) -> str:
        """The generator's own name; empty where an analog output drives."""
        return self._output.identity if isinstance(self._output, Generator) else ""

    def on_device_lost(self) -> None:
        """The device is gone: whatever is on its output ends by itself, or by the supervisor's handle."""
        if isinstance(self._output, AnalogOutput):
            self._output.abandon()

    def reconnect(self, route: Route, devices: Sequence[DeviceInfo]) -> None:
        """The device is back: take its output again."""
        chosen = outputs_of(self._rig, devices, self._where)
        if chosen:
            self._output = AnalogOutput(route, chosen, guarded=self._guarded)

    def release_output(self, *, reachable: bool = True) -> None:
        """Bring the output to 0 V and let go of it."""
        if self._output is not None and (reachable or isinstance(self._output, Generator)):
            try:
                self._output.close()
            except DeviceBusyError:
                # Nothing of ours is on it any more: whoever took it answers for it.
                return

    def _require_no_needless_waiver(self, route: Route) -> None:
        if self._guarded or not self.physical or not (self._rig.excitation and self._rig.excitation.watchdog_waived):
            return
        try:
            Watchdog(route, route.address.device, self.physical, PROBE_S).close()
        except ConfigurationError:
            return
        raise ConfigurationError(
            "the rig file goes without a watchdog, and this device has one",
            where=f"{self._where}, rig file field excitation.watchdog_waived",
            remedy="set excitation.watchdog_s, such as 0.4, and leave watchdog_waived out",
        )

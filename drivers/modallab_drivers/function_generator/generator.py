"""A sine generator as the shaker's drive: every setting read back and watched, every burst ending by itself."""

import time
from collections.abc import Generator as Yields
from contextlib import contextmanager
from math import ceil, cos, pi

from modallab.bench.protocol import Burst
from modallab.core.errors import BenchError, ConfigurationError, DeviceGoneError, OutputLostError
from modallab.core.hardware import Excitation
from modallab.core.rig import Rig
from modallab_drivers.function_generator.dialects import LANGUAGES, Name
from modallab_drivers.function_generator.instrument import AMPLIFIER_OFF, Instrument
from modallab_drivers.function_generator.line import InstrumentLine, number_without_unit

STEP_S = 0.03
"""Between two steps of the amplitude while it rises or falls."""

MIN_STEPS = 32
"""Of a cosine: its largest step is then 5 % of the level."""

EMERGENCY_TRIES = 3

LOOK_EVERY_S = 0.05
"""While a burst is on, some settings are asked for so often; of an instrument that answers in 5 ms all in 0.2 s."""


def open_generator(rig: Rig) -> "Generator":
    """The generator the rig file names, its output off.

    Raises:
        ConfigurationError: a field of the rig file that does not fit the instrument.
        DeviceGoneError: nothing answers.
    """
    excitation = rig.excitation
    if excitation is None or excitation.dialect is None or not excitation.output:
        missing = "excitation.output" if excitation is None or not excitation.output else "excitation.dialect"
        raise ConfigurationError(
            f"{missing}: missing; allowed: a serial port or a VISA address, and one of {', '.join(LANGUAGES)}",
            where=f"rig {rig.name}",
            remedy="add it to the rig file",
        )
    language = LANGUAGES[excitation.dialect]
    if rig.limits is not None and rig.limits.drive_v > language.highest_v:
        raise ConfigurationError(
            f"limits.drive_v: found {rig.limits.drive_v:g} V; allowed: up to the generator's {language.highest_v:g} V",
            where=f"rig {rig.name}",
            remedy="correct this field of the rig file",
        )
    return Generator(InstrumentLine(excitation.output, excitation.baud), excitation.dialect)


def emergency_off(excitation: Excitation) -> None:
    """Switch the output off through a line of one's own.

    Raises:
        DeviceGoneError: it could not be done: the amplifier must be switched off by hand.
    """
    if excitation.dialect is None:
        return
    try:
        _bring_down(excitation.output, excitation.baud, excitation.dialect)
    except BenchError as error:
        raise DeviceGoneError(error.what, where=error.where, remedy=AMPLIFIER_OFF) from error


def _bring_down(address: str, baud: int, dialect: str) -> None:
    line = InstrumentLine(address, baud)
    try:
        for tries_left in reversed(range(EMERGENCY_TRIES)):
            try:
                line.identify()
                return Instrument(line, dialect).bring_down()
            except BenchError:
                # On a serial port its owner may have taken our answer, as we may have taken the owner's.
                if not tries_left:
                    raise
    finally:
        line.close()


class Generator:
    """One channel of a generator.

    A burst is a whole number of cycles that the instrument counts itself, so it ends by itself; the amplitude rises and
    falls in steps, which the bench's sample count paces. Meanwhile the settings are asked for in turn: what somebody
    changes at the front panel ends the burst. At its end the output is switched off.
    """

    def __init__(self, line: InstrumentLine, dialect: str) -> None:
        """Check who answers, switch the output off, and set what never changes."""
        self._line, self._instrument = line, Instrument(line, dialect)
        self._language = self._instrument.language
        self._steps: list[tuple[int, float]] = []
        self._next_look = self._look_every = self._fall = 0
        self._held: dict[str, float | str] = {}
        self._ends_s = 0.0
        self._as_left = True
        try:
            self.identity = self._instrument.require_dialect()
            self._instrument.bring_down()
            self._set_up()
        except BaseException:
            line.close()
            raise

    @property
    def range_v(self) -> float:
        """The largest amplitude it can give into an open end."""
        return self._language.highest_v

    @property
    def busy(self) -> bool:
        """Whether a burst is on."""
        return bool(self._steps)

    def play(self, burst: Burst, now: int, rate_hz: float) -> None:
        """Start a burst at its lowest amplitude; `tick` takes it up and down again.

        Raises:
            ConfigurationError: the instrument does not take what the burst needs; the output is off.
            OutputLostError: a setting is not as it was left; the output is off.
        """
        with self._safely():
            if self._as_left:
                self._require_unchanged(at_all=True)
            else:
                self._set_up()
            self.set("frequency", burst.frequency_hz)
            self.set("cycles", float(ceil(burst.duration_s * burst.frequency_hz)))
            self.set("amplitude", self._language.lowest_vpp)
            self._ends_s = time.monotonic() + burst.duration_s + 1 / burst.frequency_hz
            self._steps = [(now + round(t * rate_hz), volts) for t, volts in _staircase(burst)]
            self._fall = now + round((burst.ramp_s + burst.hold_s) * rate_hz)
            self._held = {}
            self.set("output", "ON")
            self._line.send(self._language.trigger)
            if errors := self._instrument.errors():
                raise ConfigurationError(
                    f"trigger: it reports {', '.join(errors)}", where=self._instrument.place_in_messages
                )
        self._look_every = max(1, round(LOOK_EVERY_S * rate_hz))
        self._next_look = now + self._look_every

    def next_event(self) -> int | None:
        """The sample at which the amplitude takes its next step, or its settings are looked at."""
        return min(self._steps[0][0], self._next_look) if self._steps else None

    def tick(self, now: int) -> None:
        """Take the steps that are due, of several the last, and look whether the settings still stand.

        Raises:
            OutputLostError: somebody changed one, or an answer came too late; the output was brought to 0 V.
            DeviceGoneError: the line died: the amplifier must be switched off by hand.
        """
        if not self._steps:
            return
        with self._safely():
            self._step(now)
            if self._steps and now >= self._next_look:
                self._next_look = now + self._look_every
                self._require_unchanged(at_all=False)

    def facts(self) -> dict[str, float | str]:
        """What the instrument took of the last burst: while its hold is on read back now, later as at its end.

        Raises:
            OutputLostError: a setting was changed; the output was brought to 0 V.
            DeviceGoneError: the line died.
        """
        if self._steps and not self._held:
            with self._safely():
                return self._taken()
        return self._held

    def _taken(self) -> dict[str, float | str]:
        self._require_unchanged(at_all=True)
        taken = self._instrument.taken
        return {
            "generator_frequency_hz": number_without_unit(taken["frequency"]),
            "generator_amplitude_v": number_without_unit(taken["amplitude"]) / 2,
        }

    def zero(self) -> None:
        """Bring the output down and switch it off.

        Raises:
            DeviceGoneError: the line is dead, or the output stays on.
        """
        self._steps = []
        try:
            self._bring_down()
        except DeviceGoneError as error:
            self._say_amplifier(error)
            raise

    def close(self) -> None:
        """Switch the output off and let go of the port."""
        try:
            self.zero()
        except DeviceGoneError:
            # A burst that is on ends by itself.
            return
        finally:
            self._line.close()

    def set(self, name: Name, value: float | str) -> None:
        """Set, read back, and ask for errors.

        Raises:
            ConfigurationError: it was rejected, or another value was applied; the output is off.
        """
        try:
            self._instrument.set(name, value)
        except ConfigurationError:
            self._instrument.bring_down()
            raise

    def _set_up(self) -> None:
        self._as_left = True
        self._instrument.errors()
        self.set("output", "OFF")
        for name, word in self._language.constants.items():
            self.set(name, word)
        self.set("amplitude", self._language.lowest_vpp)
        self.set("frequency", 1000.0)
        self.set("cycles", 1.0)

    def _step(self, now: int) -> None:
        due = [volts for sample, volts in self._steps if sample <= now]
        if not due:
            return
        if now >= self._fall and not self._held:
            # What was changed in the last moments of the hold must be seen before the fall covers it.
            self._held = self._taken()
        self._steps = self._steps[len(due) :]
        if not self._steps:
            self._bring_down()
        else:
            # Steps come fast: its queue of errors is asked at the next burst.
            self._instrument.set("amplitude", max(2 * due[-1], self._language.lowest_vpp), ask_errors=False)

    def _require_unchanged(self, *, at_all: bool) -> None:
        if changed := self._instrument.changed_settings(at_all=at_all):
            raise OutputLostError(
                f"{changed}: it was changed at the front panel or by another program, or the generator was switched off"
                " and on; the output was brought to 0 V",
                where=self._instrument.place_in_messages,
                remedy="do not operate the generator during a test; its settings are written again for the next burst",
            )

    @contextmanager
    def _safely(self) -> Yields[None]:
        """Whatever goes wrong: bring the output to 0 V, and say so if that cannot be done."""
        try:
            yield
        except BenchError as error:
            self._steps = []
            # Only at the next burst: whoever waits must not wait for that too.
            self._as_left = False
            try:
                self._bring_down()
            except BenchError as dead:
                self._say_amplifier(error)
                raise error from dead
            if isinstance(error, DeviceGoneError):
                raise OutputLostError(
                    f"{error.what}; the generator answers again, and the output was brought to 0 V",
                    where=self._instrument.place_in_messages,
                    remedy="check the cable and other programs that use the generator",
                ) from error
            raise

    def _bring_down(self) -> None:
        self._instrument.bring_down()
        self._ends_s = 0.0

    def _say_amplifier(self, error: BenchError) -> None:
        """Raise what the operator must do where a burst may still be on."""
        left_s = self._ends_s - time.monotonic()
        if left_s > 0:
            raise DeviceGoneError(
                f"the line to the generator died in a burst: {error.what}; the output may still be driven, and"
                f" ends by itself only after at most {left_s:.3g} s",
                where=self._instrument.place_in_messages,
                remedy=AMPLIFIER_OFF,
            ) from error


def _staircase(burst: Burst) -> list[tuple[float, float]]:
    """(seconds from the start, volts) of every step; the last one is the end."""
    count = max(MIN_STEPS, ceil(burst.ramp_s / STEP_S)) if burst.ramp_s > 0 else 1
    rise = [(burst.ramp_s * k / count, burst.amplitude_v * (1 - cos(pi * (k + 1) / count)) / 2) for k in range(count)]
    top = burst.ramp_s + burst.hold_s
    fall = [(top + burst.ramp_s * k / count, burst.amplitude_v * (1 + cos(pi * (k + 1) / count)) / 2)
            for k in range(count)]  # fmt: skip
    return [*rise, *fall, (burst.duration_s, 0.0)]

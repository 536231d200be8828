"""A sine generator as the shaker's drive: every setting read back, every burst ending by itself."""

from math import ceil, cos, pi

from modallab.bench.protocol import Burst
from modallab.core.errors import BenchError, ConfigurationError, DeviceGoneError
from modallab.core.hardware import Excitation
from modallab.core.rig import Rig
from modallab_drivers.function_generator.dialects import LANGUAGES, Language, Name, agrees
from modallab_drivers.function_generator.line import SerialLine

STEP_S = 0.05
"""Between two steps of the amplitude while it rises or falls."""

MIN_STEPS = 4


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
            f"{missing}: missing; allowed: a serial port and one of {', '.join(LANGUAGES)}",
            where=f"rig {rig.name}",
            remedy="add it to the rig file",
        )
    language = LANGUAGES[excitation.dialect]
    if rig.limits is not None and rig.limits.drive_v > language.highest_v:
        raise ConfigurationError(
            f"limits.drive_v: found {rig.limits.drive_v:g} V; allowed: up to the generator's {language.highest_v:g} V",
            where=f"rig {rig.name}",
            remedy="mend this field of the rig file",
        )
    return Generator(SerialLine(excitation.output, excitation.baud), excitation.dialect)


def emergency_off(excitation: Excitation) -> None:
    """Switch the output off through a line of one's own.

    Raises:
        DeviceGoneError: the port cannot be opened; a burst that is on ends by itself.
    """
    if excitation.dialect is None:
        return
    line = SerialLine(excitation.output, excitation.baud)
    try:
        _switch_off(line, LANGUAGES[excitation.dialect])
    finally:
        line.close()


def _switch_off(line: SerialLine, language: Language) -> None:
    # A line that is closed, or an error that is raised, must not overtake what was said last: so an answer is awaited.
    setting = language.settings["output"]
    line.send(setting.command.format("OFF"))
    if not agrees("OFF", setting.read(line.ask(setting.ask))):
        raise DeviceGoneError(
            "the output was switched off and is still on", where=line.port, remedy="switch the amplifier off"
        )


class Generator:
    """One channel of a generator.

    A burst is a whole number of cycles that the instrument counts itself, so it ends by itself; the amplitude rises and
    falls in steps, which the bench's sample count paces. At its end the output is switched off.
    """

    def __init__(self, line: SerialLine, dialect: str) -> None:
        """Check who answers, switch the output off, and set what never changes."""
        self._line, self._dialect = line, dialect
        self._language: Language = LANGUAGES[dialect]
        self._steps: list[tuple[int, float]] = []
        try:
            self._require_dialect()
            self._drain_errors()
            self.set("output", "OFF")
            for name, word in self._language.words.items():
                self.set(name, word)
            self.set("offset", 0.0)
            self.set("amplitude", self._language.lowest_vpp)
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
        """Start a burst at its lowest amplitude; `tick` takes it up and down again."""
        self.set("frequency", burst.frequency_hz)
        self.set("cycles", float(ceil(burst.duration_s * burst.frequency_hz)))
        self.set("amplitude", self._language.lowest_vpp)
        self.set("output", "ON")
        self._line.send(self._language.trigger)
        self._require_no_error("trigger")
        self._steps = [(now + round(t * rate_hz), volts) for t, volts in _staircase(burst)]

    def next_event(self) -> int | None:
        """The sample at which the amplitude takes its next step."""
        return self._steps[0][0] if self._steps else None

    def tick(self, now: int) -> None:
        """Take the steps that are due; of several, the last."""
        due = [volts for sample, volts in self._steps if sample <= now]
        if not due:
            return
        self._steps = self._steps[len(due) :]
        if not self._steps:
            self.zero()
        else:
            self.set("amplitude", max(2 * due[-1], self._language.lowest_vpp))

    def zero(self) -> None:
        """Switch the output off."""
        self._steps = []
        self.set("output", "OFF")

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
        setting = self._language.settings[name]
        self._line.send(setting.command.format(value if isinstance(value, str) else f"{value:.9g}"))
        try:
            found = setting.read(self._line.ask(setting.ask))
            good = agrees(value, found)
        except ValueError as error:
            found, good = str(error), False
        errors = self._drain_errors()
        if good and not errors:
            return
        if name != "output":
            _switch_off(self._line, self._language)
        raise self._rejected(f"{name}: {value} was set, the generator says {found}", errors)

    def _require_dialect(self) -> None:
        answer = self._line.ask("*IDN?")
        language = self._language
        maker = answer.casefold().startswith(tuple(m.casefold() for m in language.makers))
        if not (maker and any(model in answer for model in language.models)):
            raise ConfigurationError(
                f"excitation.dialect: found {self._dialect}, but {answer!r} answers",
                where=f"generator on {self._line.port}",
                remedy=f"choose the instrument's own dialect: {', '.join(LANGUAGES)}",
            )

    def _require_no_error(self, what: str) -> None:
        errors = self._drain_errors()
        if errors:
            _switch_off(self._line, self._language)
            raise self._rejected(what, errors)

    def _drain_errors(self) -> list[str]:
        found: list[str] = []
        # A queue has its end; an instrument that never says so is not read for ever.
        for _ in range(32):
            answer = self._line.ask("SYST:ERR?")
            if answer.lstrip("+").startswith("0"):
                return found
            found.append(answer)
        return found

    def _rejected(self, what: str, errors: list[str]) -> BenchError:
        errors_said = f"; it reports {', '.join(errors)}" if errors else ""
        return ConfigurationError(
            f"{what}{errors_said}", where=f"generator on {self._line.port}", remedy="ask for what the instrument can do"
        )


def _staircase(burst: Burst) -> list[tuple[float, float]]:
    """(seconds from the start, volts) of every step; the last one is the end."""
    count = max(MIN_STEPS, ceil(burst.ramp_s / STEP_S)) if burst.ramp_s > 0 else 1
    rise = [(burst.ramp_s * k / count, burst.amplitude_v * (1 - cos(pi * (k + 1) / count)) / 2) for k in range(count)]
    top = burst.ramp_s + burst.hold_s
    fall = [(top + burst.ramp_s * k / count, burst.amplitude_v * (1 + cos(pi * (k + 1) / count)) / 2)
            for k in range(count)]  # fmt: skip
    return [*rise, *fall, (burst.duration_s, 0.0)]

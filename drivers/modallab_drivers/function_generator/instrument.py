"""One generator's settings: set, read back, asked for again, and brought down."""

import time
from collections import deque
from contextlib import suppress

from modallab.core.errors import ConfigurationError, DeviceGoneError
from modallab_drivers.function_generator.dialects import DANGEROUS, LANGUAGES, Name
from modallab_drivers.function_generator.line import InstrumentLine, number_without_unit, value_matches

AMPLIFIER_OFF = "switch the shaker's amplifier off by hand now: nothing else can end the output"

STOP_STEPS = 25
"""Of 4 % of the level each, where the instrument is fast enough."""

STOP_STEP_S = 0.002
SLOW_S = 0.01
SELDOM = 8
"""Of an instrument whose answers take longer than SLOW_S, only every so many steps one is awaited."""

MOST_ERRORS = 32
AMPLITUDE_EVERY = 2
"""Between two looks at the amplitude, at most so many at other settings."""
LOOK_S = 0.02
"""How long one look at the settings may take: others are waiting for their samples."""


class Instrument:
    """A generator on a line, and what it took of what was set.

    Attributes:
        language: its dialect.
        taken: what was read back, as the instrument wrote it, by name.
    """

    def __init__(self, line: InstrumentLine, dialect: str) -> None:
        self.line, self.language = line, LANGUAGES[dialect]
        self.taken: dict[Name, str] = {}
        self._wanted: dict[Name, float | str] = {}
        self._queue: deque[Name] = deque()
        self._dialect = dialect

    @property
    def place_in_messages(self) -> str:
        """For messages."""
        return self.line.place_in_messages

    def require_dialect(self) -> str:
        """Ask who it is, which is returned.

        Raises:
            ConfigurationError: not an instrument of the rig file's dialect.
        """
        answer, language = self.line.identify(), self.language
        maker = answer.casefold().startswith(tuple(m.casefold() for m in language.makers))
        if not (maker and any(model in answer for model in language.models)):
            raise ConfigurationError(
                f"excitation.dialect is {self._dialect}, but the instrument identifies itself as {answer!r}",
                where=self.place_in_messages,
                remedy=f"choose the instrument's own dialect: {', '.join(LANGUAGES)}",
            )
        return answer

    def set(self, name: Name, value: float | str, *, ask_errors: bool = True) -> None:
        """Set, read back, and ask for errors.

        Raises:
            ConfigurationError: it was rejected, or what was applied differs by more than the stated tolerance.
        """
        self.set_with_next_question(name, value)
        errors = self.errors() if ask_errors else []
        found, good = self._found(name)
        if not good or errors:
            reports = f"; it reports {', '.join(errors)}" if errors else ""
            raise ConfigurationError(
                f"{name}: {value} was set, the generator reports {found}{reports}",
                where=self.place_in_messages,
                remedy="request a value that the instrument supports",
            )

    def set_with_next_question(self, name: Name, value: float | str) -> None:
        """Set together with the next question, which reads it back."""
        text = value if isinstance(value, str) else f"{value:.7g}"
        self._wanted[name] = value
        self.line.hold_back(self.language.settings[name].command.format(text))

    def errors(self) -> list[str]:
        """All errors it has noted."""
        found: list[str] = []
        # A queue has its end; an instrument that never says so is not read for ever.
        while self.language.errors and len(found) < MOST_ERRORS:
            answer = self.line.ask(self.language.errors)
            if answer.lstrip("+").startswith("0"):
                break
            found.append(answer)
        return found

    def changed_settings(self, *, at_all: bool) -> str:
        """What is no longer as it was set, in words, or empty: at all settings, or at as many as fit into LOOK_S."""
        if at_all:
            self._queue.clear()
        self._queue = self._queue or self._round(at_all=at_all)
        until, answers = time.monotonic() + LOOK_S, dict[str, str]()
        while self._queue and (at_all or not answers or time.monotonic() < until):
            name = self._queue.popleft()
            found, good = self._found(name, answers)
            if not good:
                self._queue.clear()
                return self._cause(name, found, answers)
        return ""

    def _round(self, *, at_all: bool) -> deque[Name]:
        names = deque(sorted(self._wanted, key=_danger))
        if not at_all and "amplitude" in names:
            # What drives most is asked for most often: of a slow instrument a whole round takes half a second.
            for place in range(len(names) - 1, 2, -AMPLITUDE_EVERY):
                names.insert(place, "amplitude")
        return names

    def _cause(self, name: Name, found: str, answers: dict[str, str]) -> str:
        # Without the burst mode a Siglent shows no carrier, and another load changes what is shown of every voltage.
        for cause in ("burst", "load"):
            if name not in ("output", cause):
                other, good = self._found(cause, answers)
                if not good:
                    name, found = cause, other
                    break
        return f"{name}: {self._wanted[name]} was set, the generator now reports {found}"

    def bring_down(self) -> None:
        """Bring the amplitude down in steps, then switch the output off, by every way the instrument knows.

        Raises:
            DeviceGoneError: the output stays on, or nothing answers: it was done blindly and cannot be confirmed.
        """
        try:
            if self._is_off():
                return
            self._ramp_down(answering=True)
            for remedy in ("", "*CLS", "*RST"):
                # An instrument that holds an unread error may obey nothing else; a reset switches every output off.
                if remedy:
                    self.line.hold_back(remedy)
                self.set_with_next_question("offset", 0.0)
                self.set_with_next_question("output", "OFF")
                if self._is_off():
                    return
        except DeviceGoneError:
            with suppress(DeviceGoneError):
                self._ramp_down(answering=False)
                self.set_with_next_question("output", "OFF")
                self.line.flush()
            raise
        raise DeviceGoneError(
            "the output was switched off, but the generator does not confirm it", where=self.place_in_messages,
            remedy=AMPLIFIER_OFF,
        )  # fmt: skip

    def _is_off(self) -> bool:
        # An answer is awaited: a line that is closed, or an error that is raised, must not overtake what was sent.
        try:
            return value_matches("output", "OFF", self.language.settings["output"].read(self._ask("output")))
        except (ValueError, ConfigurationError):
            return False

    def _ramp_down(self, *, answering: bool) -> None:
        lowest, vpp = self.language.lowest_vpp, self._amplitude_now(answering=answering)
        step, left, unasked, every = vpp / STOP_STEPS, vpp, 0, 1
        while left > lowest:
            left, unasked = max(lowest, left - step), unasked + 1
            self.set_with_next_question("amplitude", left)
            # Steps wait for their answers: else the network would hand over several at once.
            if answering and unasked >= every:
                asked_s, unasked = time.monotonic(), 0
                with suppress(ConfigurationError):
                    self._ask("amplitude")
                every = SELDOM if time.monotonic() - asked_s > SLOW_S else 1
            else:
                self.line.flush()
            time.sleep(STOP_STEP_S)

    def _amplitude_now(self, *, answering: bool) -> float:
        """In Vpp: what the instrument says, or what it was set to last."""
        if answering:
            with suppress(ValueError, ConfigurationError):
                return number_without_unit(self.language.settings["amplitude"].read(self._ask("amplitude")))
        return float(self._wanted.get("amplitude", self.language.lowest_vpp))

    def _ask(self, name: Name) -> str:
        return self.line.ask(self.language.settings[name].ask)

    def _found(self, name: Name, answers: dict[str, str] | None = None) -> tuple[str, bool]:
        setting = self.language.settings[name]
        known = answers if answers is not None else {}
        if setting.ask not in known:
            known[setting.ask] = self._ask(name)
        try:
            found = self.taken[name] = setting.read(known[setting.ask])
            return found, value_matches(name, self._wanted[name], found)
        except ValueError as error:
            return str(error), False


def _danger(name: Name) -> int:
    return DANGEROUS.index(name) if name in DANGEROUS else len(DANGEROUS)

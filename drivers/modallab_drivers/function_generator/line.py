"""Lines of text to an instrument and back, each answer to its own question, and what it says as numbers and words."""

import re
import time
from math import inf

from modallab.core.errors import BenchError, ConfigurationError, DeviceGoneError
from modallab_drivers.function_generator.transports import open_transport

INFINITE_OHM = 9e36
"""An open end is a number to most: 9.9E+37."""

AMPLITUDE_TOLERANCE = 0.005
FREQUENCY_TOLERANCE = 1e-5
"""Relative; an instrument rounds to its own steps."""

STEP = {"amplitude": 0.001, "frequency": 0.001, "offset": 0.001, "cycles": 0.0, "phase": 0.1}
"""Vpp, Hz, V, cycles and degrees: the coarsest steps of the instruments that are spoken to."""

_WORDS = {
    "1": "ON", "0": "OFF", "SINE": "SIN", "SINUSOID": "SIN", "TRIGGERED": "TRIG", "NCYC": "TRIG", "MANUAL": "MAN",
    "HZ": "INF", "INFINITY": "INF", "HIGHZ": "INF",
}  # fmt: skip
_PREFIX = {"": 1.0, "U": 1e-6, "K": 1e3, "M": 1e6}
_NUMBER = re.compile(r"([-+]?[0-9.]+(?:E[-+]?[0-9]+)?)([UKM]?)(HZ|VPP|V|S)?", re.IGNORECASE)


def keyed_values(answer: str) -> dict[str, str]:
    """Values by key in an answer such as `C1:OUTP ON,LOAD,HZ` or `C1:BTWV STATE,ON,TIME,1,CARR,WVTP,SINE`.

    A value without a key is the STATE; what follows CARR belongs to the carrier, whose keys are `CARR.AMP` and so on.
    """
    words = answer.partition(" ")[2].split(",")
    if words[0] in ("ON", "OFF"):
        words = ["STATE", *words]
    cut = words.index("CARR") if "CARR" in words else len(words)
    own, carrier = words[:cut], words[cut + 1 :]
    found = dict(zip(own[0::2], own[1::2], strict=False))
    return found | {f"CARR.{key}": value for key, value in zip(carrier[0::2], carrier[1::2], strict=False)}


def number_without_unit(text: str) -> float:
    """A number with or without its unit; infinite for an open end, however it is called.

    Raises:
        ValueError: it is none.
    """
    if _WORDS.get(text.upper(), text.upper()) == "INF":
        return inf
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is no number")
    prefix = _PREFIX[match[2].upper()]
    if match[2] == "m" or (prefix == 1e6 and not (match[3] or "").upper().startswith("HZ")):
        prefix = 1e-3
    value = float(match[1]) * prefix
    return inf if value >= INFINITE_OHM else value


def value_matches(name: str, wanted: float | str, found: str) -> bool:
    """Whether what is read back is what was set, within the stated tolerance of a number.

    Raises:
        ValueError: a number was due, and something else came.
    """
    if name == "load":
        return number_without_unit(found) == inf
    if isinstance(wanted, str) and name not in STEP:
        return _WORDS.get(wanted.upper(), wanted.upper()) == _WORDS.get(found.upper(), found.upper())
    relative = {"amplitude": AMPLITUDE_TOLERANCE, "frequency": FREQUENCY_TOLERANCE}.get(name, 0.0)
    value = float(wanted)
    return abs(number_without_unit(found) - value) <= relative * abs(value) + STEP[name] * (1 + 1e-9)


TIMEOUT_S = 1.0
SPENT_S = 0.02
"""Nothing more came for so long: no late answer is on its way."""

_REMEDY = "check cable, address or port, baud rate and the instrument's remote setting"


class InstrumentLine:
    """One open way to an instrument.

    An instrument answers in order. So after an answer that did not come in time it is asked who it is, which nothing
    else answers alike, and all that comes before its name is dropped.
    """

    def __init__(self, address: str, baud: int) -> None:
        """Open it.

        Raises:
            DeviceGoneError: there is no such address, or it is taken.
        """
        self.address = address
        self.identity = ""
        self._behind = False
        self._held = ""
        try:
            self._transport = open_transport(address, baud, TIMEOUT_S)
        except (OSError, ValueError) as error:
            raise DeviceGoneError(
                f"it cannot be opened: {error}", where=self.place_in_messages, remedy=_REMEDY
            ) from error

    @property
    def place_in_messages(self) -> str:
        """For messages."""
        return f"generator on {self.address} (rig file field excitation.output)"

    def identify(self) -> str:
        """Ask who it is.

        Raises:
            BenchError: nobody answers, or nothing that can be read.
        """
        self.identity = self.ask("*IDN?")
        return self.identity

    def hold_back(self, text: str) -> None:
        """Keep a line back: it goes out together with the next question.

        In a network two short messages in a row wait for each other; one with both does not.
        """
        self._held += f"{text}\n"

    def send(self, text: str) -> None:
        """Send a line, and before it what was kept back.

        Raises:
            DeviceGoneError: the line is dead.
        """
        self.hold_back(text)
        self.flush()

    def flush(self) -> None:
        """Send what was kept back.

        Raises:
            DeviceGoneError: the line is dead.
        """
        lines, self._held = self._held, ""
        try:
            self._transport.write(lines.encode("ascii"))
        except OSError as error:
            raise self._gone(lines.strip(), str(error)) from error

    def ask(self, text: str) -> str:
        """Send a line and wait for its answer.

        Raises:
            DeviceGoneError: the line is dead, or nothing came in time.
            ConfigurationError: what came is the question itself, or no text.
        """
        if self._behind:
            self._catch_up()
        try:
            self._transport.discard_input()
        except OSError as error:
            raise self._gone(text, str(error)) from error
        self.send(text)
        answer = self._read(text, TIMEOUT_S)
        if self.identity and answer == self.identity and text != "*IDN?":
            answer = self._read(text, TIMEOUT_S)
        if answer == text:
            raise self._unreadable(f"{text!r} is echoed", "switch the instrument's echo off")
        return answer

    def close(self) -> None:
        """Let go of it."""
        self._transport.close()

    def _read(self, text: str, timeout_s: float) -> str:
        try:
            line, complete = self._transport.read(timeout_s)
        except OSError as error:
            raise self._gone(text, str(error)) from error
        if not complete:
            self._behind = bool(self.identity)
            came = f"only {line[:40]!r} without a line feed came" if line else "no answer"
            raise self._gone(text, f"{came} within {timeout_s:g} s")
        try:
            return line.decode("ascii").strip()
        except UnicodeDecodeError as error:
            raise self._unreadable(f"{line[:20]!r} answers {text!r}, which is no text", "set the same baud rate and "
                                   "framing at both ends (excitation.baud)") from error  # fmt: skip

    def _catch_up(self) -> None:
        held, self._held = self._held, ""
        self.send("*IDN?")
        until = time.monotonic() + TIMEOUT_S
        while self._read("*IDN?", max(until - time.monotonic(), SPENT_S)) != self.identity:
            if time.monotonic() > until:
                raise self._gone("*IDN?", "another instrument answers")
        self._behind = False
        try:
            while self._transport.read(SPENT_S)[1]:
                pass
        except OSError as error:
            raise self._gone("*IDN?", str(error)) from error
        self._held = held

    def _gone(self, text: str, why: str) -> DeviceGoneError:
        return DeviceGoneError(f"{text!r}: {why}", where=self.place_in_messages, remedy=_REMEDY)

    def _unreadable(self, what: str, remedy: str) -> BenchError:
        self._behind = bool(self.identity)
        return ConfigurationError(what, where=self.place_in_messages, remedy=remedy)

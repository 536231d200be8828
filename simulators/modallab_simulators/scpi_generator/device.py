"""The instrument: a line of text in, a line of text or nothing out."""

import re
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from modallab_simulators.ni_daqmx_server.lines import Hold, OutputLine
from modallab_simulators.scpi_generator.settings import WORDS, GeneratorSettings, SineBurst, SineDialect

LATENCY_S = 0.002


class SimulatedClock(Protocol):
    """The time of the bench."""

    def now(self) -> float:
        """In s."""
        ...


class ScpiGenerator:
    """One channel of a generator.

    As the real ones do, it rounds to its own steps, clips and applies what is out of range, rescales what it shows
    when the load is changed, runs on without end when its burst mode is switched off, and rests at its offset.

    Attributes:
        clip_vpp: it applies no more, and says nothing.
        gain: it applies so many times what is asked for, and says nothing.
        deaf: it obeys no OFF: "" it does, "error" until its errors are cleared, "always".
    """

    def __init__(
        self,
        dialect: SineDialect,
        line: OutputLine,
        clock: SimulatedClock,
        changed: Callable[[], None] = lambda: None,
        lock: Any = None,
        ppm: float = 0.0,
    ) -> None:
        self.dialect = dialect
        self.clip_vpp, self.gain, self.deaf = float("inf"), 1.0, ""
        self._line, self._clock, self._changed, self._ppm = line, clock, changed, ppm
        self._lock = lock if lock is not None else threading.RLock()
        self._settings = GeneratorSettings()
        self._errors: deque[str] = deque()
        self._burst: SineBurst | None = None

    def ask(self, text: str) -> str | None:
        """Obey one line; the answer, if it was a question."""
        with self._lock:
            if text == "*IDN?":
                return self.dialect.idn
            if text == "SYST:ERR?":
                return self._oldest_error()
            if text in ("*RST", "*CLS"):
                return self._reset(everything=text == "*RST")
            if text == self.dialect.trigger:
                return self._fire()
            return self._pairs(text) if self.dialect.pairs else self._headers(text)

    def panel(self, name: str, value: str) -> None:
        """Somebody changes a setting at the front panel.

        Raises:
            ValueError: there is no such setting.
        """
        with self._lock:
            if name not in self.dialect.headers:
                raise ValueError(f"no setting {name}; known: {', '.join(self.dialect.headers)}")
            self._set(name, value)
            self._errors.clear()

    def power_cycle(self) -> None:
        """It is switched off and on."""
        with self._lock:
            self._reset(everything=True)

    def _oldest_error(self) -> str:
        if self.dialect.pairs:
            # It has no queue: the question itself is the error, every time.
            return '-108,"Parameter not allowed"'
        return self._errors.popleft() if self._errors else '+0,"No error"'

    def _reset(self, *, everything: bool) -> None:
        self._errors.clear()
        self.deaf = "always" if self.deaf == "always" else ""
        if everything and not self.deaf:
            self._settings, self._burst = GeneratorSettings(), None
            self._put()

    def _headers(self, text: str) -> str | None:
        if text.endswith("?"):
            name = self._name(text[:-1])
            return None if name is None else self._shown(name)
        header, _, value = text.partition(" ")
        name = self._name(header)
        if name is not None:
            self._set(name, value.strip())
        return None

    def _pairs(self, text: str) -> str | None:
        header, _, rest = text.partition(" ")
        if header.endswith("?"):
            return self._shown_pairs(header[:-1])
        if header == "C1:BSWV":
            # A basic wave ends the burst mode, and what was a burst runs on.
            self._set("burst", "OFF")
            header, rest = "C1:BTWV", f"CARR,{rest}"
        if header == "C1:OUTP" and "," not in rest:
            self._set("output", rest)
            return None
        key, _, value = rest.rpartition(",")
        name = self._name(f"{header} {key}")
        if name is not None:
            self._set(name, value)
        return None

    def _shown_pairs(self, header: str) -> str | None:
        words = self._settings.words
        sine = "SINE" if words["function"] == "SIN" else "SQUARE"
        carrier = (
            f"WVTP,{sine},FRQ,{self._shown('frequency')}HZ,AMP,{self._shown('amplitude')}V,"
            f"OFST,{self._shown('offset')}V,PHSE,0"
        )
        if header == "C1:BSWV":
            return f"C1:BSWV {carrier}"
        if header == "C1:OUTP":
            load = "HZ" if np.isinf(self._settings.numbers["load"]) else self._shown("load")
            return f"C1:OUTP {words['output']},LOAD,{load},POWERON_STATE,0,PLRT,NOR"
        if header == "C1:BTWV":
            if words["burst"] == "OFF":
                return "C1:BTWV STATE,OFF"
            mode = "NCYC" if words["mode"] == "TRIG" else words["mode"]
            return (
                f"C1:BTWV STATE,ON,PRD,0.01S,STPS,{self._shown('phase')},TRSR,{words['source']},TRMD,OFF,"
                f"TIME,{self._shown('cycles')},DLAY,2.4e-07S,GATE_NCYC,{mode},CARR,{carrier}"
            )
        return self._error('-113,"Undefined header"')

    def _name(self, header: str) -> str | None:
        for name, known in self.dialect.headers.items():
            if header.upper() == known:
                return name
        return self._error(f'-113,"Undefined header; {header}"')

    def _error(self, text: str) -> None:
        self._errors.append(text)

    def _shown(self, name: str) -> str:
        if name in self._settings.words:
            word = self._settings.words[name]
            return self.dialect.booleans[word == "ON"] if name in ("output", "burst") else word
        value = self._settings.numbers[name]
        if name in ("amplitude", "offset"):
            value *= self._settings.displayed_voltage
        return self.dialect.number.format(9.9e37 if np.isinf(value) else value)

    def _set(self, name: str, value: str) -> None:
        if name == "output" and value.upper() in ("OFF", "0") and self.deaf:
            self._error('-221,"Settings conflict; output off is not obeyed"')
        elif name in self._settings.words:
            self._set_word(name, value.upper())
        else:
            self._set_number(name, value)
        self._apply(name)

    def _set_word(self, name: str, value: str) -> None:
        allowed = WORDS[name]
        if value not in allowed:
            self._error(f'-224,"Illegal parameter value; {value}"')
        else:
            self._settings.words[name] = allowed[value]

    def _set_number(self, name: str, value: str) -> None:
        if name == "load" and value.upper() in ("INF", "HZ"):
            self._settings.numbers["load"] = np.inf
            return
        match = re.fullmatch(r"([-+0-9.eE]+)(?:HZ|V|VPP)?", value, re.IGNORECASE)
        if match is None:
            self._error(f'-104,"Data type error; {value}"')
            return
        self._settings.numbers[name] = self._coerced(name, float(match[1]))

    def _coerced(self, name: str, requested: float) -> float:
        dialect = self.dialect
        if name in ("amplitude", "offset"):
            requested /= self._settings.displayed_voltage
        low, high = {
            "frequency": (1e-6, 10e6),
            "amplitude": (dialect.min_vpp, dialect.max_vpp),
            "offset": (-10.0, 10.0),
            "cycles": (1.0, 1e6),
            "load": (1.0, 10e3),
            "phase": (-360.0, 360.0),
        }[name]
        applied = min(max(requested, low), high)
        if applied != requested:
            self._error(f'-222,"Data out of range; value clipped to {"lower" if requested < low else "upper"} limit"')
        step = {"amplitude": dialect.amplitude_step_vpp, "frequency": dialect.frequency_step_hz}.get(name, 0.0)
        if name == "amplitude":
            applied = min(applied * self.gain, self.clip_vpp)
        return round(applied / step) * step if step else applied

    def _apply(self, name: str) -> None:
        words = self._settings.words
        if name == "output" and words["output"] == "OFF":
            self._burst = None
        if words["burst"] == "OFF" and words["output"] == "ON" and name in ("burst", "output"):
            # No burst mode: a sine without end.
            start_s = self._burst.start_s if self._burst is not None else self._clock.now() + LATENCY_S
            self._burst = self._wave(start_s, np.inf)
        elif self._burst is not None:
            self._burst = self._wave(self._burst.start_s, self._burst.cycles)
        if name in ("output", "burst", "amplitude", "offset", "function", "frequency"):
            self._put()

    def _fire(self) -> None:
        words, numbers = self._settings.words, self._settings.numbers
        if words["burst"] != "ON" or words["source"] not in ("BUS", "MAN"):
            self._error('-211,"Trigger ignored"')
        elif words["output"] == "ON":
            self._burst = self._wave(self._clock.now() + LATENCY_S, numbers["cycles"])
            self._put()

    def _wave(self, start_s: float, cycles: float) -> SineBurst:
        words, numbers = self._settings.words, self._settings.numbers
        amplitude_v, offset_v = numbers["amplitude"] / 2, numbers["offset"]
        wave = SineBurst(start_s, numbers["frequency"], cycles, amplitude_v, self._ppm, offset_v)
        return replace(wave, square=words["function"] == "SQU")

    def _put(self) -> None:
        rest_v = self._settings.numbers["offset"] if self._settings.words["output"] == "ON" else 0.0
        self._line.put(self._clock.now() + LATENCY_S, self._burst or Hold(rest_v))
        self._changed()

"""A sine generator that speaks SCPI over a pseudo-terminal, on the clock of a simulated bench.

Four makers' languages are understood, each strictly: what is wrong goes into the error queue. As the real ones do, it
clips and applies what is out of range, and shows twice too little voltage when it is set for a 50 ohm load that is
not there.
"""

import os
import re
import select
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server.lines import Floats, Hold, OutputLine

LATENCY_S = 0.002


class Clock(Protocol):
    """The time of the bench."""

    def now(self) -> float:
        """In s."""
        ...


@dataclass(frozen=True, slots=True)
class SineDialect:
    """How one maker's generator is spoken to.

    Attributes:
        idn: answer to `*IDN?`.
        headers: what each setting is called; the value follows after a blank.
        trigger: starts a burst.
        pairs: whether settings are `C1:BSWV FRQ,10` pairs.
        max_vpp: into an open end.
        min_vpp: into an open end.
    """

    idn: str
    headers: dict[str, str]
    trigger: str
    pairs: bool = False
    max_vpp: float = 20.0
    min_vpp: float = 0.002


def _keysight(idn: str, channel: str, outputs: str) -> SineDialect:
    return SineDialect(
        idn,
        {
            "function": f"{channel}FUNC",
            "frequency": f"{channel}FREQ",
            "amplitude": f"{channel}VOLT",
            "unit": f"{channel}VOLT:UNIT",
            "offset": f"{channel}VOLT:OFFS",
            "load": f"{outputs}:LOAD",
            "output": outputs,
            "burst": f"{channel}BURS:STAT",
            "mode": f"{channel}BURS:MODE",
            "cycles": f"{channel}BURS:NCYC",
            "source": "TRIG1:SOUR" if channel else "TRIG:SOUR",
        },
        "*TRG",
    )


SINE_DIALECTS: dict[str, SineDialect] = {
    "keysight-33500": _keysight("Agilent Technologies,33511B,MY52300001,2.08", "SOUR1:", "OUTP1"),
    "keysight-33210": _keysight("Agilent Technologies,33210A,MY48000001,1.04", "", "OUTP"),
    "rigol-dg1000": SineDialect(
        "Rigol Technologies,DG1022Z,DG1ZA000000001,00.02.06",
        {
            "function": ":SOUR1:FUNC",
            "frequency": ":SOUR1:FREQ",
            "amplitude": ":SOUR1:VOLT",
            "unit": ":SOUR1:VOLT:UNIT",
            "offset": ":SOUR1:VOLT:OFFS",
            "load": ":OUTP1:LOAD",
            "output": ":OUTP1",
            "burst": ":SOUR1:BURS:STAT",
            "mode": ":SOUR1:BURS:MODE",
            "cycles": ":SOUR1:BURS:NCYC",
            "source": ":SOUR1:BURS:TRIG:SOUR",
        },
        ":SOUR1:BURS:TRIG",
    ),
    "siglent-sdg": SineDialect(
        "Siglent Technologies,SDG2042X,SDG2XAAA000001,2.01.01.35R3",
        {
            "function": "C1:BSWV WVTP",
            "frequency": "C1:BSWV FRQ",
            "amplitude": "C1:BSWV AMP",
            "offset": "C1:BSWV OFST",
            "output": "C1:OUTP",
            "load": "C1:OUTP LOAD",
            "burst": "C1:BTWV STATE",
            "mode": "C1:BTWV GATE_NCYC",
            "cycles": "C1:BTWV TIME",
            "source": "C1:BTWV TRSR",
        },
        "C1:BTWV MTRIG",
        pairs=True,
    ),
}


@dataclass(frozen=True, slots=True)
class SineBurst:
    """A finite sine of whole cycles on the generator's own clock; the output rests at 0 V before and after."""

    start_s: float
    frequency_hz: float
    cycles: float
    amplitude_v: float
    ppm: float

    def volts(self, times_s: Floats) -> Floats:
        """In V."""
        own = (times_s - self.start_s) * (1 + self.ppm * 1e-6) * self.frequency_hz
        return np.where((own > 0) & (own < self.cycles), self.amplitude_v * np.sin(2 * np.pi * own), 0.0)


@dataclass(slots=True)
class _Settings:
    numbers: dict[str, float] = field(
        default_factory=lambda: {"frequency": 1000.0, "amplitude": 0.1, "offset": 0.0, "cycles": 1.0, "load": 50.0}
    )
    words: dict[str, str] = field(
        default_factory=lambda: {
            "function": "SIN", "unit": "VPP", "output": "OFF", "burst": "OFF", "mode": "TRIG", "source": "IMM",
        }
    )  # fmt: skip


class ScpiGenerator:
    """The instrument: a line of text in, a line of text or nothing out."""

    def __init__(
        self,
        dialect: SineDialect,
        line: OutputLine,
        clock: Clock,
        changed: Callable[[], None] = lambda: None,
        lock: Any = None,
        ppm: float = 0.0,
    ) -> None:
        self.dialect = dialect
        self._line, self._clock, self._changed, self._ppm = line, clock, changed, ppm
        self._lock = lock if lock is not None else threading.RLock()
        self._settings = _Settings()
        self._errors: deque[str] = deque()
        self._burst: SineBurst | None = None
        self.clip_vpp = float("inf")

    def ask(self, text: str) -> str | None:
        """Obey one line; the answer, if it was a question."""
        with self._lock:
            if text == "*IDN?":
                return self.dialect.idn
            if text == "SYST:ERR?":
                return self._errors.popleft() if self._errors else '+0,"No error"'
            if text in ("*RST", "*CLS"):
                return self._reset(everything=text == "*RST")
            if text == self.dialect.trigger:
                return self._fire()
            return self._pairs(text) if self.dialect.pairs else self._headers(text)

    def _reset(self, *, everything: bool) -> None:
        self._errors.clear()
        if everything:
            self._settings = _Settings()
            self._off()

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
        if header == "C1:OUTP" and "," not in rest:
            self._set("output", rest)
            return None
        key, _, value = rest.partition(",")
        name = self._name(f"{header} {key}")
        if name is not None:
            self._set(name, value)
        return None

    def _shown_pairs(self, header: str) -> str | None:
        words, numbers = self._settings.words, self._settings.numbers
        if header == "C1:BSWV":
            amplitude = numbers["amplitude"]
            return (
                f"C1:BSWV WVTP,{'SINE' if words['function'] == 'SIN' else words['function']},"
                f"FRQ,{numbers['frequency']:.9g}HZ,PERI,{1 / numbers['frequency']:.6g}S,AMP,{amplitude:.9g}V,"
                f"OFST,{numbers['offset']:.9g}V,PHSE,0"
            )
        if header == "C1:OUTP":
            load = "HZ" if np.isinf(numbers["load"]) else f"{numbers['load']:g}"
            return f"C1:OUTP {words['output']},LOAD,{load},PLRT,NOR"
        if header == "C1:BTWV":
            return (
                f"C1:BTWV STATE,{words['burst']},GATE_NCYC,{words['mode']},TRSR,{words['source']},"
                f"TIME,{numbers['cycles']:.9g}"
            )
        self._errors.append('-113,"Undefined header"')
        return None

    def _name(self, header: str) -> str | None:
        for name, known in self.dialect.headers.items():
            if header.upper() == known:
                return name
        self._errors.append(f'-113,"Undefined header; {header}"')
        return None

    def _shown(self, name: str) -> str:
        if name in self._settings.words:
            word = self._settings.words[name]
            return {"ON": "1", "OFF": "0"}.get(word, word) if name in ("output", "burst") else word
        value = self._settings.numbers[name]
        return "9.9E+37" if np.isinf(value) else f"{value:+.9E}"

    def _set(self, name: str, value: str) -> None:
        if name in self._settings.words:
            self._set_word(name, value.upper())
        else:
            self._set_number(name, value)
        self._apply(name)

    def _set_word(self, name: str, value: str) -> None:
        allowed = {
            "function": {"SIN": "SIN", "SINE": "SIN"},
            "output": {"ON": "ON", "OFF": "OFF", "1": "ON", "0": "OFF"},
            "burst": {"ON": "ON", "OFF": "OFF", "1": "ON", "0": "OFF"},
            "unit": {"VPP": "VPP"},
            "mode": {"TRIG": "TRIG", "NCYC": "NCYC"},
            "source": {"BUS": "BUS", "MAN": "MAN", "IMM": "IMM"},
        }[name]
        if value not in allowed:
            self._errors.append(f'-224,"Illegal parameter value; {value}"')
        else:
            self._settings.words[name] = allowed[value]

    def _set_number(self, name: str, value: str) -> None:
        if name == "load" and value.upper() in ("INF", "HZ"):
            self._settings.numbers["load"] = np.inf
            return
        match = re.fullmatch(r"([-+0-9.eE]+)(?:HZ|V|VPP)?", value, re.IGNORECASE)
        if match is None:
            self._errors.append(f'-104,"Data type error; {value}"')
            return
        requested = float(match[1])
        low, high = {
            "frequency": (1e-6, 10e6),
            "amplitude": (self.dialect.min_vpp, self.dialect.max_vpp),
            "offset": (-10.0, 10.0),
            "cycles": (1.0, 1e6),
            "load": (1.0, 10e3),
        }[name]
        applied = min(max(requested, low), high)
        if applied != requested:
            self._errors.append(f'-222,"Data out of range; value clipped to {applied:g}"')
        if name == "amplitude":
            applied = min(applied, self.clip_vpp)
        self._settings.numbers[name] = applied

    def _apply(self, name: str) -> None:
        if name == "output" and self._settings.words["output"] == "OFF":
            self._off()
        elif name == "amplitude" and self._burst is not None:
            self._put(replace(self._burst, amplitude_v=self._amplitude_v))

    @property
    def _amplitude_v(self) -> float:
        # The shown voltage is that at the load it was set for; at an open end there is twice as much.
        load = self._settings.numbers["load"]
        return self._settings.numbers["amplitude"] / 2 * (1.0 if np.isinf(load) else (load + 50) / load)

    def _fire(self) -> None:
        words, numbers = self._settings.words, self._settings.numbers
        if words["burst"] != "ON" or words["source"] not in ("BUS", "MAN"):
            self._errors.append('-211,"Trigger ignored"')
        elif words["output"] == "ON":
            start = self._clock.now() + LATENCY_S
            self._put(SineBurst(start, numbers["frequency"], numbers["cycles"], self._amplitude_v, self._ppm))

    def _put(self, burst: SineBurst) -> None:
        self._burst = burst
        self._line.put(self._clock.now() + LATENCY_S, burst)
        self._changed()

    def _off(self) -> None:
        self._burst = None
        self._line.put(self._clock.now() + LATENCY_S, Hold(0.0))
        self._changed()


class PtyGenerator:
    """A generator behind a pseudo-terminal, which a serial package opens as it opens a port."""

    def __init__(self, device: ScpiGenerator) -> None:
        import tty

        self._device = device
        self._own, self._theirs = os.openpty()
        self._plug, self._pull = os.pipe()
        # Raw at both ends, or the terminal would echo and translate; one end kept open, or it would hang up.
        tty.setraw(self._own)
        tty.setraw(self._theirs)
        self.port = os.ttyname(self._theirs)
        self._dead = False
        self._thread = threading.Thread(target=self._serve, name="scpi", daemon=True)
        self._thread.start()

    def fault(self, line: str) -> None:
        """Arm a fault: `clipped-set-point 0.1`, `dead-line`, `unplugged`.

        Raises:
            ValueError: a generator cannot have it.
        """
        kind, words = faults.parse(line, faults.GENERATOR_FAULTS)
        if kind == faults.CLIPPED:
            self._device.clip_vpp = float(words[0])
        elif kind in (faults.DEAD_LINE, faults.TIME_OUT):
            self._dead = True
        else:
            self.close()

    def close(self) -> None:
        """Pull the plug."""
        if self._pull < 0:
            return
        # The thread is gone before its descriptors are: else it could read from whatever gets their numbers next.
        os.write(self._pull, b"x")
        self._thread.join()
        for descriptor in (self._theirs, self._own, self._plug, self._pull):
            os.close(descriptor)
        self._pull = -1

    def _serve(self) -> None:
        pending, waiting = b"", select.poll()
        for descriptor in (self._own, self._plug):
            waiting.register(descriptor, select.POLLIN)
        while all(descriptor != self._plug for descriptor, _ in waiting.poll()):
            *lines, pending = (pending + os.read(self._own, 4096)).split(b"\n")
            for line in lines:
                answer = None if self._dead else self._device.ask(line.decode("ascii", "replace").strip())
                if answer is not None:
                    os.write(self._own, answer.encode("ascii") + b"\n")

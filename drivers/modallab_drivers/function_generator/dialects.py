"""How each maker's generator is spoken to: a table a dialect, and no other difference in the code."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isinf
from typing import Literal

Name = Literal[
    "function", "frequency", "amplitude", "unit", "offset", "load", "output", "burst", "mode", "cycles", "source"
]


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting.

    Attributes:
        command: what sets it, with the value in braces.
        ask: what asks for it.
        key: what stands before its value in an answer of many pairs; empty: the answer is the value.
    """

    command: str
    ask: str
    key: str = ""

    def read(self, answer: str) -> str:
        """The value in an answer, without its unit.

        Raises:
            ValueError: it is not in there.
        """
        if not self.key:
            return answer.strip()
        words = answer.partition(" ")[2].split(",")
        if self.key == "0":
            return words[0]
        pairs = dict(zip(words[0::2], words[1::2], strict=False)) | dict(zip(words[1::2], words[2::2], strict=False))
        if self.key not in pairs:
            raise ValueError(f"no {self.key} in {answer!r}")
        return pairs[self.key].removesuffix("HZ" if self.key == "FRQ" else "V").removesuffix("S")


@dataclass(frozen=True, slots=True)
class Language:
    """One dialect.

    Attributes:
        makers: one of these begins the answer to `*IDN?`.
        models: one of these is in it.
        settings: by name.
        words: the values of the words, by name.
        trigger: starts a burst.
        lowest_vpp: smallest amplitude into an open end.
        highest_v: largest amplitude into an open end.
    """

    makers: tuple[str, ...]
    models: tuple[str, ...]
    settings: dict[Name, Setting]
    words: dict[Name, str]
    trigger: str
    lowest_vpp: float = 0.002
    highest_v: float = 10.0


def _plain(prefix: str, outputs: str, source: str) -> dict[Name, Setting]:
    def one(header: str) -> Setting:
        return Setting(f"{header} {{}}", f"{header}?")

    return {
        "function": one(f"{prefix}FUNC"),
        "frequency": one(f"{prefix}FREQ"),
        "unit": one(f"{prefix}VOLT:UNIT"),
        "amplitude": one(f"{prefix}VOLT"),
        "offset": one(f"{prefix}VOLT:OFFS"),
        "load": one(f"{outputs}:LOAD"),
        "output": one(outputs),
        "burst": one(f"{prefix}BURS:STAT"),
        "mode": one(f"{prefix}BURS:MODE"),
        "cycles": one(f"{prefix}BURS:NCYC"),
        "source": one(source),
    }


def _words(source: str) -> dict[Name, str]:
    return {"function": "SIN", "unit": "VPP", "load": "INF", "burst": "ON", "mode": "TRIG", "source": source}


LANGUAGES: dict[str, Language] = {
    "keysight-33500": Language(
        ("Agilent", "Keysight"), ("335", "336"), _plain("SOUR1:", "OUTP1", "TRIG1:SOUR"),
        _words("BUS"), "*TRG",
    ),
    "keysight-33210": Language(
        ("Agilent", "Keysight"), ("33210", "33220", "33250"), _plain("", "OUTP", "TRIG:SOUR"),
        _words("BUS"), "*TRG",
    ),
    "rigol-dg1000": Language(
        ("Rigol",), ("DG10", "DG8", "DG9"), _plain(":SOUR1:", ":OUTP1", ":SOUR1:BURS:TRIG:SOUR"),
        _words("MAN"), ":SOUR1:BURS:TRIG",
    ),
    "siglent-sdg": Language(
        ("Siglent",), ("SDG",),
        {
            "function": Setting("C1:BSWV WVTP,{}", "C1:BSWV?", "WVTP"),
            "frequency": Setting("C1:BSWV FRQ,{}", "C1:BSWV?", "FRQ"),
            "amplitude": Setting("C1:BSWV AMP,{}", "C1:BSWV?", "AMP"),
            "offset": Setting("C1:BSWV OFST,{}", "C1:BSWV?", "OFST"),
            "load": Setting("C1:OUTP LOAD,{}", "C1:OUTP?", "LOAD"),
            "output": Setting("C1:OUTP {}", "C1:OUTP?", "0"),
            "burst": Setting("C1:BTWV STATE,{}", "C1:BTWV?", "STATE"),
            "mode": Setting("C1:BTWV GATE_NCYC,{}", "C1:BTWV?", "GATE_NCYC"),
            "cycles": Setting("C1:BTWV TIME,{}", "C1:BTWV?", "TIME"),
            "source": Setting("C1:BTWV TRSR,{}", "C1:BTWV?", "TRSR"),
        },
        {"function": "SINE", "load": "HZ", "burst": "ON", "mode": "NCYC", "source": "MAN"}, "C1:BTWV MTRIG",
    ),
}  # fmt: skip

_SAME = {"1": "ON", "0": "OFF", "SINE": "SIN", "9.9E+37": "INF", "+9.9E+37": "INF", "HZ": "INF"}

number: Callable[[str], float] = lambda text: inf if _SAME.get(text.upper()) == "INF" else float(text)  # noqa: E731


def agrees(set_value: float | str, found: str) -> bool:
    """Whether what is read back is what was set, in whatever form."""
    if isinstance(set_value, str):
        return _SAME.get(set_value.upper(), set_value.upper()) == _SAME.get(found.upper(), found.upper())
    value = number(found)
    return not isinf(value) and abs(value - set_value) <= 1e-6 * abs(set_value) + 1e-9

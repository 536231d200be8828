"""How each maker's generator is spoken to: a table a dialect, and no other difference in the code.

Sources: the makers' programming guides, 33500 Series Operating and Service Guide, 33210A User's Guide, DG1000Z
Programming Guide (PGB09102), SDG Series Programming Guide (PG02).
"""

from dataclasses import dataclass, field
from typing import Literal

from modallab_drivers.function_generator.line import keyed_values

Name = Literal[
    "function", "frequency", "amplitude", "unit", "offset", "load", "output", "burst", "mode", "cycles", "source",
    "phase",
]  # fmt: skip

DANGEROUS: tuple[Name, ...] = ("output", "amplitude", "burst", "frequency", "function", "offset", "load", "cycles")
"""What the shaker feels at once when it changes: looked at before all else."""


@dataclass(frozen=True, slots=True)
class InstrumentSetting:
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
        """The value in an answer.

        Raises:
            ValueError: it is not in there.
        """
        if not self.key:
            return answer
        found = keyed_values(answer)
        if self.key not in found:
            raise ValueError(f"no {self.key} in {answer!r}")
        return found[self.key]


@dataclass(frozen=True, slots=True)
class CommandLanguage:
    """One dialect.

    Attributes:
        makers: one of these begins the answer to `*IDN?`.
        models: one of these is in it.
        settings: by name.
        constants: what is set once and never changes, in the order in which it must be set.
        trigger: starts a burst.
        lowest_vpp: smallest amplitude into an open end.
        highest_v: largest amplitude into an open end.
        errors: asks for the oldest error; empty: it has no queue that can be read, and only what is read back counts.
    """

    makers: tuple[str, ...]
    models: tuple[str, ...]
    settings: dict[Name, InstrumentSetting]
    constants: dict[Name, str] = field(default_factory=dict[Name, str])
    trigger: str = "*TRG"
    lowest_vpp: float = 0.002
    highest_v: float = 10.0
    errors: str = "SYST:ERR?"


def _plain(prefix: str, outputs: str, source: str) -> dict[Name, InstrumentSetting]:
    def one(header: str) -> InstrumentSetting:
        return InstrumentSetting(f"{header} {{}}", f"{header}?")

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
        "phase": one(f"{prefix}BURS:PHAS"),
        "source": one(source),
    }


def _siglent() -> dict[Name, InstrumentSetting]:
    # While bursts are on, the sine is their carrier: BSWV would end the burst mode, and the output would run on.
    def burst(key: str) -> InstrumentSetting:
        return InstrumentSetting(f"C1:BTWV {key},{{}}", "C1:BTWV?", key)

    def carrier(key: str) -> InstrumentSetting:
        return InstrumentSetting(f"C1:BTWV CARR,{key},{{}}", "C1:BTWV?", f"CARR.{key}")

    return {
        "function": carrier("WVTP"),
        "frequency": carrier("FRQ"),
        "amplitude": carrier("AMP"),
        "offset": carrier("OFST"),
        "load": InstrumentSetting("C1:OUTP LOAD,{}", "C1:OUTP?", "LOAD"),
        "output": InstrumentSetting("C1:OUTP {}", "C1:OUTP?", "STATE"),
        "burst": burst("STATE"),
        "mode": burst("GATE_NCYC"),
        "cycles": burst("TIME"),
        "phase": burst("STPS"),
        "source": burst("TRSR"),
    }


def _constants(source: str) -> dict[Name, str]:
    # The load comes first: it changes what an amplitude means.
    return {
        "load": "INF", "function": "SIN", "unit": "VPP", "burst": "ON", "mode": "TRIG", "source": source, "phase": "0",
        "offset": "0",
    }  # fmt: skip


LANGUAGES: dict[str, CommandLanguage] = {
    "keysight-33500": CommandLanguage(
        ("Agilent", "Keysight"), ("335", "336"), _plain("SOUR1:", "OUTP1", "TRIG1:SOUR"), _constants("BUS"),
    ),
    "keysight-33210": CommandLanguage(
        ("Agilent", "Keysight"), ("33210", "33220", "33250"), _plain("", "OUTP", "TRIG:SOUR"), _constants("BUS"),
        lowest_vpp=0.02,
    ),
    "rigol-dg1000": CommandLanguage(
        ("Rigol",), ("DG10", "DG8", "DG9"), _plain(":SOUR1:", ":OUTP1", ":SOUR1:BURS:TRIG:SOUR"), _constants("MAN"),
        trigger=":SOUR1:BURS:TRIG",
    ),
    "siglent-sdg": CommandLanguage(
        ("Siglent",), ("SDG",), _siglent(),
        {"load": "HZ", "burst": "ON", "function": "SINE", "mode": "NCYC", "source": "MAN", "phase": "0", "offset": "0"},
        trigger="C1:BTWV MTRIG", lowest_vpp=0.004, errors="",
    ),
}  # fmt: skip

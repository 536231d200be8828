"""Ten generators that misbehave in the hold of a burst: is the output at 0 V in time, and is the cause named?

`python benchmarks/misbehaving_generators.py [repetitions]`: on the wall's clock, over pseudo-terminals with pyserial
and over TCP sockets with pyvisa-py. Safe is: 0 V within LIMIT_S where the instrument answers; where it does
not, an error that says that the amplifier must be switched off. No block of such a burst would be kept, since the
error ends the run.
"""

import random
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from generator_bench import RATE_HZ, Bench, make

from modallab.bench.protocol import Burst
from modallab.core.errors import BenchError
from modallab_drivers.function_generator import line

BURST = Burst(40.0, 2.0, 0.3, 4.0)
LIMIT_S = 0.5


@dataclass(frozen=True)
class Case:
    """A fault, and what must be seen of it.

    Attributes:
        name: in words.
        dialect: of the instrument.
        way: pty or socket.
        begin: what goes wrong.
        named: a word of the message, or of its remedy.
        reachable: whether the instrument can still be brought to 0 V.
        mute_s: how long it does not answer, which is added to the limit.
    """

    name: str
    dialect: str
    way: str
    begin: Callable[[Bench], None]
    named: str
    reachable: bool = True
    mute_s: float = 0.0


def faults(*lines: str) -> Callable[[Bench], None]:
    def begin(bench: Bench) -> None:
        for each in lines:
            bench.port.arm_fault(each)

    return begin


def another_program(text: str) -> Callable[[Bench], None]:
    """Somebody else's script opens a second connection."""

    def begin(bench: Bench) -> None:
        with socket.create_connection(("127.0.0.1", int(bench.port.port.split("::")[2]))) as connection:
            connection.sendall(f"{text}\n".encode())
            time.sleep(0.01)

    return begin


CASES = [
    Case("another program sets a basic wave: the burst mode ends, 8 Vpp without end", "siglent-sdg", "socket",
         another_program("C1:BSWV AMP,8"), "burst"),
    Case("another program resets it", "keysight-33500", "socket", another_program("*RST"), "output"),
    Case("answers after 25 ms each, and the amplitude is turned up by hand", "rigol-dg1000", "pty",
         faults("slow-answers 0.025", "front-panel amplitude 12"), "amplitude"),
    Case("the load is set to 50 ohm by hand and a step of the amplitude follows", "keysight-33210", "pty",
         faults("front-panel load 50"), "load"),
    Case("square wave by hand", "siglent-sdg", "pty", faults("front-panel function SQU"), "function"),
    Case("power fails for a moment", "rigol-dg1000", "socket", faults("power-cycle"), "off"),
    Case("one answer comes too late, and OFF is not obeyed until its errors are cleared", "keysight-33500", "pty",
         faults("stays-on error", "late-answer 0.45"), "no answer", mute_s=0.45),
    Case("never obeys OFF, and its offset is turned up by hand", "rigol-dg1000", "pty",
         faults("stays-on always", "front-panel offset 1.5"), "amplifier", reachable=False),
    Case("noise on the cable makes its answers unreadable", "keysight-33210", "pty", faults("garbage"), "amplifier",
         reachable=False),
    Case("plug pulled", "siglent-sdg", "socket", faults("unplugged"), "amplifier", reachable=False),
]  # fmt: skip


def run(case: Case, at_s: float) -> tuple[bool, bool, str]:
    """Whether it was safe, whether the cause was named, and figures."""
    bench = make(case.dialect, case.way)
    generator = bench.open()
    began = time.monotonic()
    generator.play(BURST, 0, RATE_HZ)
    error: BenchError | None = None
    fault = began
    try:
        bench.pace(generator, began, at_s)
        fault = time.monotonic()
        case.begin(bench)
        bench.pace(generator, began, BURST.ramp_s + BURST.hold_s)
    except BenchError as raised:
        error = raised
    end = time.monotonic()
    volts = bench.volts(fault, end + 0.05)
    on = np.flatnonzero(np.abs(volts) > 0.011)
    last_s = on[-1] / 50e3 if len(on) else 0.0
    said = f"{error.what} {error.remedy}" if error is not None else ""
    zero = last_s < min(LIMIT_S + case.mute_s, end - fault + 0.04)
    safe = error is not None and (zero if case.reachable else "amplifier" in error.remedy)
    bench.port.close()
    return safe, case.named in said, f"last above 11 mV {last_s:.3f} s after the fault"


def main() -> None:
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    line.TIMEOUT_S = 0.3
    draw = random.Random(1)
    good = 0
    for case in CASES:
        results = [run(case, draw.uniform(0.5, 2.0)) for _ in range(repetitions)]
        both = all(safe and named for safe, named, _ in results)
        good += both
        print(f"{'good' if both else 'BAD '}  {case.name}: safe {sum(r[0] for r in results)}, rightly named "
              f"{sum(r[1] for r in results)} of {repetitions}; {results[-1][2]}", flush=True)  # fmt: skip
    print(f"{good} of {len(CASES)} safe and rightly named")


if __name__ == "__main__":
    main()

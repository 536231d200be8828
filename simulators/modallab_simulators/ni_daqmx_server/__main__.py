"""`python -m modallab_simulators.ni_daqmx_server --rig rig.json`: serve until standard input closes.

The first line on standard output is JSON with the port. Then every line on standard input is one thing an operator
does: `strike 10`, `preamplifiers sine`, `fault unplugged`, `levels`, `time`; each is answered by one line of JSON.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import grpc
import numpy as np
import yaml

from modallab.core.rig import Rig
from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.counter_task import LineTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.lines import MEMORY_S, OutputLine
from modallab_simulators.ni_daqmx_server.max_config import SavedConfiguration, read
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.plant import CablePlant, CantileverPlant, Plant
from modallab_simulators.ni_daqmx_server.rpc import serve
from modallab_simulators.ni_daqmx_server.signals import BenchClock, Pulses
from modallab_simulators.ni_daqmx_server.systems import SYSTEMS
from modallab_simulators.scpi_generator import SINE_DIALECTS, PtyGenerator, ScpiGenerator


def trace(system: SimulatedSystem, over_s: float, rate_hz: float) -> list[float]:
    """What stood on the shaker's line over the last `over_s`, oldest first.

    Raises:
        ValueError: it is not known for so long.
    """
    if over_s > MEMORY_S:
        raise ValueError(f"a line is remembered for {MEMORY_S:g} s, not for {over_s:g} s")
    now = system.clock.now()
    return system.shaker_line.volts(now - np.arange(round(over_s * rate_hz))[::-1] / rate_hz).tolist()


def levels(system: SimulatedSystem, over_s: float = 0.05) -> dict[str, float]:
    """Largest magnitude on every output over the last `over_s`, and the lines' last changes."""
    now = system.clock.now()
    times = np.linspace(now - over_s, now, 500)
    lines = dict(system.lines)
    if system.generator_line is not None:
        lines["generator"] = system.generator_line
    found = {name: float(np.abs(line.volts(times)).max()) for name, line in lines.items()}
    for task in system.tasks.values():
        if isinstance(task, LineTask):
            found |= {f"{name} changes": float(task.changes) for name in task.lines}
    return found


def arm(system: "SimulatedSystem", line: str) -> None:
    """Arm a fault, as an operator types it: `unplugged -201003`, `status ReadAnalogF64 -200279 2`.

    Raises:
        ValueError: the simulated devices cannot have it.
    """
    kind, words = faults.parse_fault(line, faults.DAQ_FAULTS)
    arguments: dict[str, Any] = {
        faults.SAMPLES_LOST: ("ReadAnalogF64", status.NO_LONGER_AVAILABLE),
        faults.TIME_OUT: ("ReadAnalogF64", 0),
        faults.PARTIAL: ("ReadAnalogF64", 0),
        faults.WARNING: ("ReadAnalogF64", 0),
    }
    if kind in arguments:
        call, code = arguments[kind]
        system.faults.arm(faults.ArmedFault(call, code, kind, int(words[0]) if words else 1))
    elif kind == faults.STATUS:
        system.faults.arm(faults.ArmedFault(words[0], int(words[1]), kind, int(words[2]) if len(words) > 2 else 1))
    else:
        _break(system, kind, words)


def _break(system: "SimulatedSystem", kind: str, words: list[str]) -> None:
    inputs = [task for task in system.tasks.values() if isinstance(task, InputTask)]
    if kind == faults.UNPLUGGED:
        code = int(words[0]) if words else status.DEVICE_GONE
        system.reserved.gone = dict.fromkeys([*system.modules, *system.chassis], code)
        for task in [t for t in system.tasks.values() if isinstance(t, OutputTask)]:
            # The samples came through the cable, which no server changes.
            task.starve(system.clock)
    elif kind == faults.PLUGGED:
        # A device that comes back has forgotten its tasks.
        system.reserved.gone = {}
        system.forget(list(system.tasks.values()))
    elif kind == faults.RESERVED:
        system.reserved.hold(words[0], words[1] if len(words) > 1 else "another program")
    elif kind == faults.RELEASED:
        system.reserved.drop(words[0])
    elif kind == faults.INVALID:
        system.forget(inputs)
    elif kind == faults.DEAD_LINE:
        for task in inputs:
            task.dead.add(int(words[0]))


def main() -> int:
    """Serve until the owner closes standard input."""
    arguments = _parser().parse_args()
    system = build(arguments)
    started: dict[str, object] = {}
    generator: PtyGenerator | None = None
    if arguments.generator:
        system.generator_line = OutputLine()
        device = ScpiGenerator(
            SINE_DIALECTS[arguments.generator], system.generator_line, system.clock, system.changed, system.lock,
            ppm=system.plant.generator_ppm,
        )  # fmt: skip
        generator = PtyGenerator(device)
        started["generator"] = generator.port
    server, started["port"] = serve(system, arguments.port, _credentials(arguments.tls), local=arguments.local)
    print(json.dumps(started), flush=True)
    for line in sys.stdin:
        print(json.dumps(obey_operator(system, generator, line.strip())), flush=True)
    server.stop(None)
    return 0


def build(arguments: argparse.Namespace) -> SimulatedSystem:
    """The system that the command line asks for."""
    rig = Rig.model_validate(yaml.safe_load(arguments.rig.read_text(encoding="utf-8")))
    layout, saved = read(arguments.devices) if arguments.devices else (SYSTEMS[arguments.system], SavedConfiguration())
    inputs = [m for m in layout.modules if m.inputs]
    range_v, bits = min(m.input_range_v for m in inputs), max(m.bits for m in inputs)
    plant: Plant
    if arguments.cables:
        plant = CablePlant(sum(m.inputs for m in inputs), range_v)
    else:
        plant = CantileverPlant(arguments.bench, rig, range_v, min(bits, arguments.bits))
    return SimulatedSystem(BenchClock(arguments.pace), layout, plant, rig, saved)


def obey_operator(system: SimulatedSystem, generator: PtyGenerator | None, line: str) -> dict[str, object]:
    """Do what an operator does, and say what came of it."""
    word, _, rest = line.partition(" ")
    try:
        if word == "generator-fault" and generator is not None:
            generator.arm_fault(rest)
            return {"done": line}
        with system.lock:
            return _obey(system, word, rest)
    except (ValueError, IndexError, KeyError) as error:
        return {"error": str(error)}


def _obey(system: SimulatedSystem, word: str, rest: str) -> dict[str, object]:
    if word == "levels":
        return dict(levels(system, float(rest) if rest else 0.05))
    if word == "time":
        return {"bench_s": system.clock.now()}
    if word == "trace":
        over_s, rate_hz = map(float, rest.split())
        return {"volts": trace(system, over_s, rate_hz)}
    if word == "truth":
        return dict(system.plant.facts)
    if word == "strike":
        system.plant.strike(int(rest), system.clock.now())
    elif word == "preamplifiers" and rest in ("impact", "sine"):
        system.plant.set_preamplifiers(rest)  # just compared
    elif word == "signal":
        terminal, frequency_hz = rest.split()
        system.connected[f"/{terminal}"] = Pulses(0.0, float(frequency_hz))
    elif word == "fault":
        arm(system, rest)
    elif word == "reset-keeps-outputs":
        system.reset_keeps_outputs = True
    else:
        raise ValueError(f"unknown: {word} {rest}")
    return {"done": f"{word} {rest}"}


def _credentials(folder: Path | None) -> grpc.ServerCredentials | None:
    if folder is None:
        return None
    pair = ((folder / "server.key").read_bytes(), (folder / "server.crt").read_bytes())
    clients = folder / "clients.crt"
    if not clients.exists():
        return grpc.ssl_server_credentials([pair])
    return grpc.ssl_server_credentials([pair], clients.read_bytes(), require_client_auth=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="modallab_simulators.ni_daqmx_server", description=__doc__)
    parser.add_argument("--rig", type=Path, required=True, help="true parameters of the bench, JSON or YAML")
    parser.add_argument("--system", choices=sorted(SYSTEMS), default="9215")
    parser.add_argument(
        "--devices", type=Path, action="append", help="the vendor's file of devices, in place of --system"
    )
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--bench", default="sim://cantilever?seed=1&bad_hits=0", help="the bench behind the devices")
    parser.add_argument("--bits", type=int, default=24, help="largest number of converters")
    parser.add_argument("--pace", action="store_true", help="run in real time")
    parser.add_argument(
        "--local", action="store_true", help="bursts end with their client, as with the vendor's driver"
    )
    parser.add_argument("--cables", action="store_true", help="every input on the output by a cable, no beam")
    parser.add_argument("--generator", choices=sorted(SINE_DIALECTS), help="a serial generator on the same bench")
    parser.add_argument("--tls", type=Path, help="folder with server.crt, server.key; clients.crt: accepted clients")
    return parser


if __name__ == "__main__":
    sys.exit(main())

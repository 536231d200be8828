"""A hammer test at the terminal, driven by a script at a human's pace, with bad hits: how long, and what is caught.

The real program runs in a pseudo-terminal on the simulated bench, which strikes when and where the script says:

    python benchmarks/operator_session.py --seeds 3 --speed 8

Every time is in seconds of the bench, which may run faster than real time. Needs a POSIX system.
"""

import argparse
import json
import os
import pty
import re
import select
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from modallab.cli.demo import demo_rig
from modallab.formats.rig.rig_file import write_rig

ANSI = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\x1b[()][A-Z0-9]")
PROMPT = re.compile(
    r"(wait|strike|good|again|too early|pause|end)(?: point (\d+), hit (\d+) of (\d+))?[^\n]*\n\d+/\d+ "
)
BAD = ("wrong point", "wrong point", "wrong point", "double", "weak", "hard", "early", "oblique")
FORCE_N = (25.0, 60.0)
"""What the sensors bear everywhere, the free end too."""
REACTION_S, NEXT_POINT_S, HAND_AFTER_S, HAND_S = (1.0, 2.0), 2.0, 1.5, 1.8


@dataclass
class Score:
    """What became of the hits, by kind."""

    hits: Counter[str] = field(default_factory=Counter)
    caught: Counter[str] = field(default_factory=Counter)
    said: list[str] = field(default_factory=list)


class Script:
    """One operator, one session."""

    def __init__(self, port: int, speed: float, seed: int, bad: float, hand: bool) -> None:
        self._to = ("127.0.0.1", port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._speed, self._bad, self._hand = speed, bad, hand
        self._rng = np.random.default_rng(seed)
        self.score = Score()
        self._pending: list[tuple[float, dict[str, object]]] = []
        self._struck = ""
        self._last_point = 0
        self._phase = ""
        self._early = False
        self._hand_off = 0.0
        self.keys: list[bytes] = []

    def see(self, phase: str, point: int, news: str) -> None:
        """React to what the screen says."""
        if "too early" in news and self._early:
            self._early = False
            self.score.caught["early"] += 1
        if phase == self._phase:
            return
        before, self._phase = self._phase, phase
        if phase == "strike":
            self._strike(point)
        elif phase in ("good", "again") and self._struck:
            self._judged(phase, news)
        elif phase == "wait" and before in ("good", "again", "strike", "too early"):
            self._wait(point)

    def _wait(self, point: int) -> None:
        if self._hand:
            self._later(HAND_AFTER_S, {"act": "hold", "seconds": HAND_S})
            self._hand_off = time.monotonic() + (HAND_AFTER_S + HAND_S + 0.5) / self._speed
        if not self._early and self._rng.uniform() < self._bad / len(BAD):
            # Before the hand, or while it lies there: the tone cannot have come.
            self._early = True
            self.score.hits["early"] += 1
            self._later(float(self._rng.uniform(0.3, 1.4)), {"act": "strike", "point": point})

    def _strike(self, point: int) -> None:
        delay = self._rng.uniform(*REACTION_S) + (NEXT_POINT_S if point != self._last_point else 0.0)
        self._last_point = point
        delay = max(delay, (self._hand_off - time.monotonic()) * self._speed)
        act: dict[str, object] = {"act": "strike", "point": point, "peak_n": float(self._rng.uniform(*FORCE_N))}
        act["width_s"] = float(self._rng.uniform(0.0015, 0.004))
        kind = "good"
        if self._rng.uniform() < self._bad:
            kind = str(self._rng.choice([k for k in BAD if k != "early"]))
            act |= self._fault(kind, point)
        self._struck = kind
        self.score.hits[kind] += 1
        self._later(float(delay), act)

    def _fault(self, kind: str, point: int) -> dict[str, object]:
        rng = self._rng
        if kind == "wrong point":
            return {"point": int(rng.choice([p for p in range(1, 11) if p != point]))}
        faults: dict[str, dict[str, object]] = {
            "double": {"rebound_s": float(rng.uniform(0.015, 0.06)), "rebound_share": float(rng.uniform(0.15, 0.6))},
            "weak": {"peak_n": float(rng.uniform(4, 8))},
            "hard": {"peak_n": float(rng.uniform(600, 900))},
            "oblique": {"oblique_deg": float(rng.uniform(45, 60))},
        }
        return faults[kind]

    def _judged(self, phase: str, news: str) -> None:
        kind, self._struck = self._struck, ""
        if phase == "again":
            self.score.caught[kind] += 1
            if kind == "good":
                self.score.said.append(news)
                self.keys.append(b"a")
        elif kind != "good":
            self.score.said.append(f"missed: {kind}")
            self.keys.append(b"u")

    def _later(self, bench_s: float, act: dict[str, object]) -> None:
        self._pending.append((time.monotonic() + bench_s / self._speed, act))

    def act(self) -> None:
        """Do what is due."""
        now = time.monotonic()
        for due in [p for p in self._pending if p[0] <= now]:
            self._pending.remove(due)
            self._socket.sendto(json.dumps(due[1]).encode(), self._to)


def session(seed: int, arguments: argparse.Namespace, folder: Path) -> tuple[Score, float, str]:
    """One session: what became of the hits, bench seconds from the first prompt to the last hit, the program's end."""
    port = _free_port()
    rig, plan = folder / "rig.yaml", folder / "plan.yaml"
    write_rig(demo_rig(), rig)
    points = ", ".join(map(str, range(arguments.points, 0, -1)))
    limits = f"{{max_residual_ratio: {arguments.residual}}}"
    plan.write_text(f"{{kind: impact, points: [{points}], hits: {arguments.hits}, acceptance: {limits}}}\n")
    bench = f"sim://cantilever?seed={seed}&operator={port}&pace=1&speed={arguments.speed:g}&place_m=0.002"
    bench += _sensitivities(seed)
    command = [sys.executable, "-c", "import sys; from modallab.cli import main; sys.exit(main(sys.argv[1:]))"]
    command += ["campaign", "run", "--rig", str(rig), "--plan", str(plan), "--bench", bench]
    command += ["--data", str(folder / "data"), "--mute"]
    main, terminal = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "30", "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(
        command, stdin=terminal, stdout=terminal, stderr=terminal, env=environment, start_new_session=True
    )
    os.close(terminal)
    script = Script(port, arguments.speed, seed, arguments.bad, arguments.hand)
    began, ended, seen, last = 0.0, 0.0, "", ""
    while process.poll() is None:
        script.act()
        while script.keys:
            os.write(main, script.keys.pop(0))
        if not select.select([main], [], [], 0.01)[0]:
            continue
        try:
            seen += os.read(main, 65536).decode(errors="replace")
        except OSError:
            break
        screens = seen.split("\x1b[2J")
        seen = screens[-1][-20000:]
        for screen in screens:
            plain = ANSI.sub("", screen).replace("\r", "")
            found = PROMPT.search(plain)
            if found is None:
                continue
            if found[1] == "strike":
                began = began or time.monotonic()
            if found[1] == "good":
                ended = time.monotonic()
            if arguments.show and found[0] != last:
                print(f"{(time.monotonic() - began) * arguments.speed:8.1f} {found[0][:60]!r}")
                last = found[0]
            script.see(found[1], int(found[2] or 0), plain[: found.start()])
    os.close(main)
    process.wait()
    return script.score, (ended - began) * arguments.speed, ANSI.sub("", seen)


def _sensitivities(seed: int) -> str:
    rng = np.random.default_rng([seed, 7])
    factors = 1 + 0.01 * rng.standard_normal(10)
    return "".join(f"&effect=gain_error,channel={row},gain={factor:.4f}" for row, factor in enumerate(factors, start=1))


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def main() -> None:
    """Run the sessions and print what they came to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument("--hits", type=int, default=5)
    parser.add_argument("--bad", type=float, default=0.2, help="share of bad hits")
    parser.add_argument("--speed", type=float, default=8.0, help="times faster than real time")
    parser.add_argument("--residual", type=float, default=0.01, help="max_residual_ratio of the plan")
    parser.add_argument("--hand", action=argparse.BooleanOptionalAction, default=True, help="steadies the beam")
    parser.add_argument("--show", action="store_true", help="print how each program ended")
    arguments = parser.parse_args()
    total, minutes = Score(), []
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        with tempfile.TemporaryDirectory() as folder:
            score, seconds, end = session(seed, arguments, Path(folder))
        total.hits += score.hits
        total.caught += score.caught
        total.said += score.said
        minutes.append(seconds / 60)
        print(f"seed {seed}: {minutes[-1]:.1f} min, hits {dict(score.hits)}, caught {dict(score.caught)}", flush=True)
        if arguments.show:
            print(end)
    for kind, count in total.hits.items():
        word = "false alarms" if kind == "good" else "caught"
        print(f"{kind}: {total.caught[kind]} of {count} {word}")
    print(f"sessions: median {np.median(minutes):.1f} min, longest {max(minutes):.1f} min")
    for text in total.said:
        print(f"  {text}")


if __name__ == "__main__":
    main()

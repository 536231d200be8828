"""Runs the vendor's component tests over gRPC against the simulated server, and counts what passes.

A test that is skipped because a device is missing has not passed. Analog are the tests of files whose name says so,
and those of timing, triggers and streams, which use analog tasks.

    python benchmarks/hardware/vendor_tests.py CHECKOUT
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree as ET

from vendor.environment import interpreter, server_command

HERE = Path(__file__).parent / "vendor"

ANALOG = re.compile(r"analog|_ai\b|_ao\b|_ai_|power|timing|trigger|in_stream|out_stream")


def main() -> int:
    """Count and list."""
    arguments = _parser().parse_args()
    python = interpreter(arguments.environment, arguments.checkout)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        with subprocess.Popen(
            server_command(arguments.checkout), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as server:
            assert server.stdout is not None
            port = json.loads(server.stdout.readline())["port"]
            _run(python, arguments.checkout, port, report, arguments.select)
            server.communicate()
        return _print(report, arguments.list)


def _run(python: Path, checkout: Path, port: int, report: Path, select: list[str]) -> None:
    environment = os.environ | {
        "NI_SERVER_PORT": str(port),
        "PYTHONPATH": f"{HERE}{os.pathsep}{checkout}",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    command = [
        python, "-m", "pytest", "-q", "-p", "vendor_plugin", "-p", "no:cacheprovider", "--timeout=20", "-x",
        "--maxfail=100000", "--tb=short", f"--junitxml={report}", "-k", "grpc_init_kwargs",
        *(select or ["tests/component"]),
    ]  # fmt: skip
    subprocess.run(command, cwd=checkout, env=environment, check=False, stdout=subprocess.DEVNULL)


def _print(report: Path, listed: bool) -> int:
    counts: Counter[tuple[str, str]] = Counter()
    reasons: Counter[str] = Counter()
    for case in ET.parse(report).iter("testcase"):
        name = f"{case.get('classname', '').removeprefix('tests.component.')}::{case.get('name', '')}"
        outcome, reason = _outcome(case)
        counts["all", outcome] += 1
        if ANALOG.search(name.partition("::")[0]):
            counts["analog", outcome] += 1
        if outcome != "passed":
            reasons[reason] += 1
            if listed:
                print(f"{outcome:8} {name}\n         {reason}")
    for reason, count in reasons.most_common(40):
        print(f"{count:5}  {reason}")
    for group in ("all", "analog"):
        of = {outcome: count for (key, outcome), count in counts.items() if key == group}
        total = sum(of.values())
        print(f"{group}: {of.get('passed', 0)} of {total} passed ({of.get('passed', 0) / max(total, 1):.1%}), {of}")
    return 0


def _outcome(case: ET.Element) -> tuple[str, str]:
    for kind in ("failure", "error", "skipped"):
        found = case.find(kind)
        if found is not None:
            return kind, " ".join(str(found.get("message", "")).split())[:230]
    return "passed", ""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path, help="the vendor's Python package with its tests")
    parser.add_argument("--environment", type=Path, default=Path(tempfile.gettempdir()) / "vendor-environment")
    parser.add_argument("--list", action="store_true", help="name each test that did not pass")
    parser.add_argument("--select", nargs="*", default=[], help="tests in place of all component tests")
    return parser


if __name__ == "__main__":
    sys.exit(main())

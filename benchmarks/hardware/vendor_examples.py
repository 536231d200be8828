"""Runs the vendor's own Python examples against the simulated server, and counts those that end well.

Each example is run as it is shipped. An example that waits for Enter is given it after eight seconds, one that waits for
Ctrl+C is sent that. The signals that the examples' own comments ask for are connected first.

    python benchmarks/hardware/vendor_examples.py CHECKOUT
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from vendor.environment import interpreter, server_command

HERE = Path(__file__).parent / "vendor"

ENTER_S = 8.0
LIMIT_S = 25.0
SIGNALS = ("Dev1/PFI0 100", "Dev1/PFI8 1000", "Dev1/PFI9 1000")
"""Terminals with a square wave on them, in Hz: what the examples say has to be connected."""


def main() -> int:
    """Run all, count and list."""
    arguments = _parser().parse_args()
    python = interpreter(arguments.environment, arguments.checkout)
    folder = arguments.checkout / "examples"
    examples = [e for e in sorted(folder.rglob("*.py")) if arguments.only in str(e)]
    failed: list[tuple[Path, str]] = []
    for example in examples:
        reason = _run_one(python, arguments.checkout, example)
        if reason:
            failed.append((example.relative_to(folder), reason))
        print("F" if reason else ".", end="", flush=True)
    print()
    for name, reason in failed:
        print(f"{name}\n         {reason}")
    print(f"{len(examples) - len(failed)} of {len(examples)} examples ended well")
    return 0


def _run_one(python: Path, checkout: Path, example: Path) -> str:
    # Each has a server of its own: what one leaves running does not spoil the next.
    with subprocess.Popen(server_command(checkout), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        port = json.loads(server.stdout.readline())["port"]
        for connected in SIGNALS:
            server.stdin.write(f"signal {connected}\n")
            server.stdin.flush()
            server.stdout.readline()
        reason = _watch(python, port, example)
        server.communicate()
    return reason


def _watch(python: Path, port: int, example: Path) -> str:
    interrupted = "KeyboardInterrupt" in example.read_text(encoding="utf-8")
    command = [python, HERE / "launcher.py", f"localhost:{port}", example]
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(
            command, cwd=folder, env=os.environ | {"MPLBACKEND": "Agg"}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        ) as process,
    ):  # fmt: skip
        try:
            # An example that needs neither Enter nor Ctrl+C ends by itself meanwhile.
            process.wait(ENTER_S)
        except subprocess.TimeoutExpired:
            if interrupted:
                process.send_signal(signal.SIGINT)
        try:
            _, errors = process.communicate("\n" * 5, LIMIT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return f"did not end within {LIMIT_S:g} s"
    lines = [line for line in errors.strip().splitlines() if line.strip()]
    wrong = next((line for line in lines if line.startswith(("nidaqmx.errors", "Traceback"))), "")
    return "" if process.returncode == 0 and not wrong else f"exit {process.returncode}: {_said(lines)}"


def _said(lines: list[str]) -> str:
    kept = [n for n, line in enumerate(lines) if line.startswith(("nidaqmx.errors", "Traceback"))]
    return " | ".join(lines[kept[-1] :] if kept and not lines[kept[-1]].startswith("Trace") else lines[-4:])[:300]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path, help="the vendor's Python package with its examples")
    parser.add_argument("--environment", type=Path, default=Path(tempfile.gettempdir()) / "vendor-environment")
    parser.add_argument("--only", default="", help="part of the name of the examples to run")
    return parser


if __name__ == "__main__":
    sys.exit(main())

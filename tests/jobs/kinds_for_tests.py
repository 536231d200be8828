"""Kinds whose work is small and whose end can be steered from a test. Workers import them by name."""

import importlib
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

from modallab.core.errors import DataError
from modallab.jobs import ComputationResult, JobDefinition, ProgressCallback


def square(payload: Any, notify: ProgressCallback) -> ComputationResult:
    notify(0.5)
    return ComputationResult(
        {"square": payload["x"] ** 2, "process": os.getpid()}, {"x.txt": str(payload["x"]).encode()}
    )


def wait(payload: Any, notify: ProgressCallback) -> ComputationResult:
    """Works for a while in steps, notifying; then says which process it was."""
    steps = payload["steps"]
    for step in range(steps):
        notify(step / steps)
        time.sleep(0.02)
    return ComputationResult({"x": payload["x"], "process": os.getpid()})


def gate(payload: Any, notify: ProgressCallback) -> ComputationResult:
    """Works until a file appears, however fast or slow the machine is."""
    while not Path(payload["file"]).exists():
        notify(0.5)
        time.sleep(0.02)
    return ComputationResult({"x": payload["x"], "process": os.getpid()})


def spin(payload: Any, _notify: ProgressCallback) -> ComputationResult:
    """Never looks out for anything."""
    deadline = time.monotonic() + payload["seconds"]
    total = 0
    while time.monotonic() < deadline:
        total += 1
    return ComputationResult(total)


def reject(payload: Any, _notify: ProgressCallback) -> ComputationResult:
    raise DataError(f"x is {payload['x']}", where="x", remedy="give another x")


def break_(_payload: Any, _notify: ProgressCallback) -> ComputationResult:
    raise ZeroDivisionError("by nothing")


def die(_payload: Any, _notify: ProgressCallback) -> ComputationResult:
    os._exit(3)


def bring_in(payload: Any, notify: ProgressCallback) -> ComputationResult:
    """Imports a package that is not there yet."""
    notify(0.5)
    sys.path.insert(0, payload["folder"])
    return ComputationResult(importlib.import_module(payload["package"]).WHOLE)


def _load(parameters: dict[str, Any], inputs: tuple[str, ...]) -> dict[str, Any]:
    return parameters | {"inputs": inputs}


def kinds(folder: Path, **limits: float) -> list[JobDefinition]:
    def keep(name: str, computed: ComputationResult) -> Any:
        for file, content in computed.blobs.items():
            (folder / f"{name}-{file}").write_bytes(content)
        return computed.result

    work = {"square": square, "wait": wait, "gate": gate, "spin": spin, "reject": reject, "break": break_, "die": die}
    work["import"] = bring_in
    return [JobDefinition(name, _load, compute, keep, limits.get(name, 3600.0)) for name, compute in work.items()]


def secret_kind() -> JobDefinition:
    """A kind whose payload cannot be sent anywhere."""
    return JobDefinition("secret", lambda _, __: threading.Lock(), square, lambda _, computed: computed.result)

"""A state space as a file: NumPy's NPZ or MATLAB's MAT, the same names in both."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, savemat

from modallab.core.errors import FormatError, PlanError
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.atomic import replacing
from modallab.gap.export.state_space import StateSpace

MATRICES = ("A", "B", "C", "D")


def write_state_space(path: Path, systems: Mapping[Test, StateSpace], rig: Rig, rate_hz: float | None) -> None:
    """Write the systems of each test, continuous and, with a rate, in steps; `.mat` is MATLAB's, anything else NPZ.

    Raises:
        PlanError: at that rate the steps would show no mode.
        StorageError: the file cannot be written.
    """
    if rate_hz is not None:
        _require_rate(systems, rate_hz)
    content: dict[str, Any] = {
        "points": np.array([p.id for p in rig.points]),
        "channels": np.array([c.name for c in rig.responses]),
        "quantities": np.array([c.quantity for c in rig.responses]),
    }
    for test, system in systems.items():
        content |= {f"{name}_{test}": getattr(system, name) for name in MATRICES}
        content |= {f"delay_s_{test}": system.delay_s, f"clock_{test}": system.clock}
        if rate_hz is not None:
            stepped = system.at_rate(rate_hz)
            content |= {f"{name}d_{test}": value for name, value in zip(MATRICES, stepped, strict=True)}
            content["rate_hz"] = rate_hz
    with replacing(path) as draft:
        if path.suffix == ".mat":
            savemat(str(draft), content, appendmat=False)
        else:
            with draft.open("wb") as out:
                np.savez_compressed(out, **content)


def _require_rate(systems: Mapping[Test, StateSpace], rate_hz: float) -> None:
    first_hz = max(system.first_hz for system in systems.values())
    if rate_hz <= 2 * first_hz:
        raise PlanError(
            f"the rate of {rate_hz:g} Hz is too low: the first mode is at {first_hz:.4g} Hz",
            remedy=f"give a rate well above {2 * first_hz:.3g} Hz, preferably that of the records",
        )


def read_state_space(path: Path) -> dict[Test, StateSpace]:
    """The continuous systems of a file, by test.

    Raises:
        FormatError: it is no such file.
    """
    try:
        content: Mapping[str, Any] = loadmat(path) if path.suffix == ".mat" else np.load(path)
        tests: list[Test] = [test for test in ("impact", "sine") if f"A_{test}" in content]
        return {test: _read_system(content, test) for test in tests}
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise FormatError(f"is no state space: {error}", where=str(path), remedy="export it again") from error


def _read_system(content: Mapping[str, Any], test: Test) -> StateSpace:
    A, B, C, D = (np.asarray(content[f"{name}_{test}"], dtype=np.float64) for name in MATRICES)
    delay = np.asarray(content[f"delay_s_{test}"], dtype=np.float64).ravel()
    return StateSpace(A, B, C, D, delay, float(np.asarray(content[f"clock_{test}"]).item()))

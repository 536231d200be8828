"""Structures drawn for a case by its name, and what identification must make of them."""

import contextlib
import io
import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path

import numpy as np
from known import Known, KnownFrf, Real, Record, case

from modallab.cli import main

SEED = 20261128
RATES = (1024.0, 1652.0, 2048.0, 2560.0, 4096.0, 5120.0)


@dataclass(frozen=True)
class Drawn:
    """Two or three modes, points 1 and 2, driven at point 1."""

    modes: tuple[tuple[float, float, tuple[float, float]], ...]
    rate: float
    n: int
    seed: int

    def receptance(self, f: Real, inputs: tuple[int, ...] = (0,)) -> np.ndarray:
        """(2, inputs, lines) in m/N."""
        s = 2j * np.pi * np.asarray(f)
        return sum(
            np.outer(phi, np.array(phi)[list(inputs)])[..., None]
            / (s**2 + 4 * np.pi * f0 * zeta * s + (2 * np.pi * f0) ** 2)
            for f0, zeta, phi in self.modes
        )

    def motion(self, f: Real, derivatives: int = 2, inputs: tuple[int, ...] = (0,)) -> np.ndarray:
        return (2j * np.pi * np.asarray(f)) ** derivatives * self.receptance(f, inputs)

    @property
    def lines(self) -> Real:
        top = min(1.6 * self.modes[-1][0], 0.45 * self.rate)
        return np.arange(1, int(top / 0.25)) * 0.25

    def frf(self, quantity: str = "inertance", lines: Real | None = None) -> KnownFrf:
        """With noise of 1e-4 of the mean magnitude."""
        f = self.lines if lines is None else lines
        derivatives = {"receptance": 0, "mobility": 1, "inertance": 2}[quantity]
        h = self.motion(f, derivatives)[:, 0]
        noise = np.random.default_rng(self.seed).normal(size=(2, *h.shape))
        h = h + 1e-4 * np.abs(h).mean() * (noise[0] + 1j * noise[1])
        return KnownFrf(f, h, quantity)

    def hit(self, number: int = 1, derivatives: int = 2, size: float = 1.0) -> Record:
        n, rate = self.n, self.rate
        force = np.zeros(n)
        width = max(int(0.6 * rate / self.modes[-1][0]), 4)
        start = 40 + number
        force[start : start + width] = size * (60 + 20 * number) * np.sin(np.pi * np.arange(width) / width) ** 2
        long = 8 * n
        f = np.fft.rfftfreq(long, 1 / rate)
        motions = np.fft.irfft(self.motion(f, derivatives)[:, 0] * np.fft.rfft(force, long), long)[:, :n]
        noise = np.random.default_rng(self.seed + number)
        a1, a2 = (a + 2e-4 * np.abs(a).max() * noise.normal(size=n) for a in motions)
        return Record(force + 0.01 * noise.normal(size=n), a1, a2, rate)


def drawn(name: str) -> Drawn:
    seed = SEED + zlib.crc32(name.encode())
    random = np.random.default_rng(seed)
    rate = float(random.choice(RATES))
    first = random.uniform(0.02, 0.06) * rate
    frequencies = first * np.cumprod([1.0, *random.uniform(1.5, 2.2, int(random.integers(1, 3)))])
    modes = tuple(
        (
            round(float(f0), 4),
            round(float(random.uniform(0.005, 0.02)), 5),
            tuple(float(v) for v in np.round(random.uniform(0.3, 1.2, 2) * [1, random.choice([-1, 1])], 4)),
        )
        for f0 in frequencies
    )
    return Drawn(modes, rate, int(random.choice([2048, 4096])), seed)


def identified(folder: Path, *more: str) -> tuple[int, str, dict]:
    """Exit code, what was printed, and the first model."""
    said = io.StringIO()
    out = folder / "m.json"
    out.unlink(missing_ok=True)
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            code = main(["identify", str(folder / "out.h5"), "--json", str(out), *more])
        except SystemExit as left:
            code = left.code
    found = json.loads(out.read_text()) if out.exists() else {}
    model = found["models"][0] | {"confidence": found["assessments"][0]["confidence"]} if found else {}
    return int(code or 0), " ".join(said.getvalue().split()), model


def misfit(model: dict, drawn: Drawn, scaled: bool = True, channels: tuple[int, ...] = (0, 1)) -> str:
    """What is wrong with the modes: beyond 0.2 %, 3 % and 2 % and beyond 5 sigma; phantoms of confidence 0.5."""
    found = np.array(model["frequency_hz"])
    # A channel at fault is left out.
    channels = tuple(k for k, name in enumerate(("a1", "a2")) if name in model["outputs"]) or channels
    matched = []
    for f0, zeta, phi in drawn.modes:
        if not len(found) or abs(found / f0 - 1).min() > 5e-3:
            return f"no mode at {f0} Hz: {found.tolist()}"
        k = int(abs(found / f0 - 1).argmin())
        matched.append(k)
        if abs(found[k] / f0 - 1) > max(2e-3, 5 * model["frequency_sigma_hz"][k] / f0):
            return f"{found[k]} Hz, not {f0}"
        if abs(model["damping_ratio"][k] / zeta - 1) > max(0.03, 5 * model["damping_sigma"][k] / zeta):
            return f"damping {model['damping_ratio'][k]}, not {zeta}"
        a = np.array(model["modal_constants"]["re"][k])[:, 0]
        right = np.array([phi[c] * phi[0] for c in channels])
        sigma = np.array(model["modal_constant_sigma"][k])[:, 0]
        if scaled and (
            a.shape != right.shape or (abs(a - right) > np.maximum(0.03 * abs(right).max(), 5 * sigma)).any()
        ):
            return f"{f0} Hz: constants {a.tolist()}, not {right.tolist()}"
    more = [float(f) for k, f in enumerate(found) if k not in matched and model["confidence"][k] > 0.5]
    return f"more modes: {more}" if more else ""


def modes(right: Drawn, **how: object) -> Callable[[Path], str]:
    """Looks whether the campaign gives these modes."""

    def check(folder: Path) -> str:
        code, said, model = identified(folder)
        return misfit(model, right, **how) if not code and model else f"not identified: {said}"

    return check


def modes_or_said(right: Drawn, words: str, **how: object) -> Callable[[Path], str]:
    """The modes are right, or identification rejects the records for a reason that matches."""
    import re

    def check(folder: Path) -> str:
        code, said, model = identified(folder)
        if code or not model:
            return "" if re.search(words, said) else f"rejected for another reason: {said}"
        return misfit(model, right, **how)

    return check


def draws(kind: str, modes_of: Callable[[Drawn], Callable[[Path], str]] = modes) -> Callable:
    """A case of a structure drawn by its name: `write(folder, drawn)`. What is read must give its modes, too."""

    def put(write: Callable[[Path, Drawn], Known]) -> Callable[[Path], Known]:
        @wraps(write)
        def written(folder: Path) -> Known:
            d = drawn(write.__name__)
            known = write(folder, d)
            numbers = known.records or known.frf
            return replace(known, check=modes_of(d)) if numbers and not known.check else known

        return case(kind)(written)

    return put

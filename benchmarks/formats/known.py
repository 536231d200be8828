"""A structure whose numbers are known, what a case must give, and the list of cases."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
RATE = 2000.0
N = 1024
G = 9.80665
MODES = ((40.0, 0.010, (0.70, 0.45)), (130.0, 0.015, (0.50, -0.80)))
"""Frequency in Hz, damping ratio, and mass-normalised shape at points 1 and 2, in 1/sqrt(kg)."""

RIG = """format_version: 2
name: a case
model: unknown
points: [{{id: 1, x_m: 0.1}}, {{id: 2, x_m: 0.3}}]
channels:
- {{index: 0, name: force, quantity: force, unit: N, point: 1{more}}}
- {{index: 1, name: a1, quantity: {quantity}, unit: {unit}, point: 1{more}}}
- {{index: 2, name: a2, quantity: {quantity}, unit: {unit}, point: 2{more}}}
"""
PLAIN = RIG.format(quantity="acceleration", unit="m/s^2", more="")
VELOCITY = RIG.format(quantity="velocity", unit="m/s", more="")
DISPLACEMENT = RIG.format(quantity="displacement", unit="m", more="")
VOLTS = RIG.format(quantity="acceleration", unit="m/s^2", more=", sensitivity_v_per_unit: 0.01")


def receptance(f: Real, outputs: tuple[int, ...] = (0, 1), inputs: tuple[int, ...] = (0,)) -> NDArray[np.complex128]:
    """(outputs, inputs, lines) in m/N."""
    s = 2j * np.pi * np.asarray(f)
    total = np.zeros((len(outputs), len(inputs), len(s)), complex)
    for f0, zeta, shape in MODES:
        w0 = 2 * np.pi * f0
        phi = np.array(shape)
        total += np.outer(phi[list(outputs)], phi[list(inputs)])[..., None] / (s**2 + 2 * zeta * w0 * s + w0**2)
    return total


def inertance(f: Real, outputs: tuple[int, ...] = (0, 1), inputs: tuple[int, ...] = (0,)) -> NDArray[np.complex128]:
    return (2j * np.pi * np.asarray(f)) ** 2 * receptance(f, outputs, inputs)


@dataclass(frozen=True)
class Record:
    """Force in N and two responses (accelerations in m/s^2 unless said), each (n,), at `rate` Hz."""

    force: Real
    a1: Real
    a2: Real
    rate: float = RATE

    def part(self, first: int, last: int | None = None) -> "Record":
        chosen = slice(first, last)
        return Record(self.force[chosen], self.a1[chosen], self.a2[chosen], self.rate)

    @property
    def rows(self) -> Real:
        """(3, n)."""
        return np.vstack([self.force, self.a1, self.a2])

    @property
    def time(self) -> Real:
        return np.arange(len(self.force)) / self.rate


def hit(number: int = 1, derivatives: int = 2, n: int = N, rate: float = RATE) -> Record:
    """A hit at point 1; the responses are displacements, differentiated so often."""
    force = np.zeros(n)
    width = int(0.006 * rate)
    force[60 : 60 + width] = (60 + 20 * number) * np.sin(np.pi * np.arange(width) / width) ** 2
    long = 4 * n
    f = np.fft.rfftfreq(long, 1 / rate)
    spectra = (2j * np.pi * f) ** derivatives * receptance(f)[:, 0] * np.fft.rfft(force, long)
    a1, a2 = np.fft.irfft(spectra, long)[:, :n]
    noise = np.random.default_rng(number)
    level = 2e-4
    a1, a2 = (a + level * np.abs(a).max() * noise.normal(size=n) for a in (a1, a2))
    return Record(force + 0.01 * noise.normal(size=n), a1, a2, rate)


def moved(record: Record, later: tuple[int, int, int]) -> tuple[list[Real], Record]:
    """Rows that each begin so many samples later, and the record that all of them cover."""
    rows = [row[k:] for row, k in zip(record.rows, later, strict=True)]
    return rows, record.part(max(later))


@dataclass(frozen=True)
class KnownFrf:
    """Of both outputs to point 1: (outputs, lines) in SI at (lines,) Hz, and what it is of."""

    frequency: Real
    values: NDArray[np.complex128]
    quantity: str = "inertance"
    coherence: Real | None = None


@dataclass(frozen=True)
class Known:
    """What is right: records, FRFs, or modes and places of a file; or why it must be rejected.

    Attributes:
        files: names of what is imported, in the folder of the case.
        options: of the command.
        rig: content of the rig file; None for a drafted one.
        rejected: a pattern that a true reason matches; with numbers beside it either is right.
        says: a pattern that the output must match, as a note on what was left out.
        tolerance: of the numbers, relative to the largest; what the digits of the file allow.
        check: of anything else: takes the folder, gives what is wrong.
    """

    files: tuple[str, ...]
    records: tuple[Record, ...] = ()
    frf: KnownFrf | None = None
    options: tuple[str, ...] = ("--drive-point", "1")
    rig: str | None = PLAIN
    rejected: str = ""
    says: str = ""
    tolerance: float = 2e-5
    check: Callable[[Path], str] | None = None

    @property
    def healthy(self) -> bool:
        """Whether there are numbers to be had, so that the file is not to blame."""
        return bool(self.records or self.frf or self.check)


@dataclass(frozen=True)
class Case:
    """One case: its kind, its name, and the function that writes its files into a folder."""

    kind: str
    name: str
    write: Callable[[Path], Known]
    about: str = field(default="")


CASES: list[Case] = []


def case(kind: str) -> Callable[[Callable[[Path], Known]], Callable[[Path], Known]]:
    """Puts a function into the list of cases; its docstring says what the file is."""

    def put(write: Callable[[Path], Known]) -> Callable[[Path], Known]:
        CASES.append(Case(kind, write.__name__, write, (write.__doc__ or "").strip()))
        return write

    return put

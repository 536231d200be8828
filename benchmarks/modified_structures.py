"""A mass, spring, damper or absorber on a plate or a tube: predicted from measured FRFs, beside its exact modes.

    python benchmarks/modified_structures.py 40 benchmarks/results/modified_structures.csv

Structures as built: uneven, sensors off their points and by their sensitivities, hits 2 mm off, with noise. A row is a
mode below half the band and the nearest one of the matrices with the addition: measured again, two modes that an
absorber damps by several per cent overlap, and are found as one. All sensors, and what is added, act along z.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigvals

from by_seed import measure

sys.path.insert(0, str(Path(__file__).parent / "gap"))

import structures

import modallab as ml
from modallab.core.model import ModalModel
from modallab.core.rig import Tolerance
from modallab.modification.attachments import AttachedPart, Element, TunedAbsorber
from modallab.modification.known import KnownStructure
from modified import COLUMNS, beside, summary
from updated import moved, plate_places, rig_of, tube_places

FIRST_SEED, LINES, ZETA, NOISE, HITS = 10101, 3000, 0.004, 1e-3, 5
TOLERANCE = Tolerance.usual()
Row = Callable[[np.ndarray, str], np.ndarray]


class Exact(NamedTuple):
    """Modes without an error, each (modes,): Hz, its deviation, damping ratio."""

    frequency_hz: np.ndarray
    frequency_sigma_hz: np.ndarray
    damping_ratio: np.ndarray


class Bench:
    """A plate or a tube with its sensors, before and after."""

    def __init__(self, seed: int, thickness: float = 1.0) -> None:
        self.rng = np.random.default_rng(seed)
        kind = ("plate", "tube")[seed % 2]
        self.places = plate_places() if kind == "plate" else tube_places()
        self.axes, self.along = "z", 2 if kind == "plate" else 1
        uneven = {
            n: structures.field(self.rng, s) for n, s in (("stiff_x", TOLERANCE.stiffness_field), ("mass_x", 2e-3))
        }
        whole = {"plate": structures.plate, "tube": structures.tube}[kind](
            structures.Material(thickness=thickness, **uneven)
        )
        omega, phi = whole.modes(len(whole.mass) - 1)
        heavy = whole.mass @ phi
        self.mass, self.stiffness, self.row = whole.mass, whole.stiffness, whole.row
        self.damping = (heavy * (2 * ZETA * omega)) @ heavy.T
        self.omega, self.high_hz = omega, float(omega[9:11].mean()) / 2 / np.pi
        self.sensors = moved(self.places, self.rng, self.along)
        self.gain = 1 + TOLERANCE.sensitivity * self.rng.standard_normal(len(self.places) * len(self.axes))
        self.hits = len(self.places), len(self.places) // 2
        self.rig = rig_of(self.places, self.axes)

    @property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mass, stiffness and damping."""
        return self.mass, self.stiffness, self.damping

    def like(self, mass: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, row: Row) -> "Bench":
        """A structure of these matrices, with the same sensors and hits."""
        other = object.__new__(Bench)
        other.__dict__ = self.__dict__ | {"mass": mass, "stiffness": stiffness, "damping": damping, "row": row}
        return other

    def drawn(self) -> tuple[str, float, int, AttachedPart]:
        """What is added: sizes are shares of the modal mass, stiffness and damping of a mode below half the band."""
        kind = ("mass", "spring", "damper", "absorber")[int(self.rng.integers(4))]
        point, mode = int(self.rng.integers(3, len(self.places) + 1)), int(self.rng.integers(4))
        row = self.row(self.places[point - 1], "z")
        _, phi = structures.Matrices(self.mass, self.stiffness, self.row).modes(4)
        felt = 1 / max(float(np.max((row @ phi) ** 2)), 1e-12)
        share, w = float(np.exp(self.rng.uniform(np.log(0.01), np.log(0.15)))), float(self.omega[mode])
        size = {
            "mass": share * felt,
            "spring": share * w**2 * felt,
            "damper": 0.1 * ZETA * w * felt,
            "absorber": share * felt,
        }[kind]
        at = (point, "z")
        added = TunedAbsorber(at, size, w / 2 / np.pi, 0.1) if kind == "absorber" else Element(at, **{kind: size})
        return kind, size, point, added

    def with_added(self, kind: str, size: float, point: int, added: AttachedPart) -> "Bench":
        """The matrices with it."""
        other = self.like(*self.matrices, self.row)
        row = self.row(self.places[point - 1], "z")
        if kind == "mass":
            other.mass = self.mass + size * np.outer(row, row)
        elif kind == "spring":
            other.stiffness = self.stiffness + size * np.outer(row, row)
        elif kind == "damper":
            other.damping = self.damping + size * np.outer(row, row)
        elif isinstance(added, TunedAbsorber):
            w = 2 * np.pi * added.frequency_hz
            link, n = np.append(row, -1.0), len(row)
            other.mass, other.stiffness, other.damping = (
                np.pad(m, (0, 1)) for m in (self.mass, self.stiffness, self.damping)
            )
            other.mass[n, n] = size
            other.stiffness += size * w**2 * np.outer(link, link)
            other.damping += 2 * added.damping_ratio * size * w * np.outer(link, link)
            other.row = lambda at, axis: np.append(self.row(at, axis), 0.0)
        return other

    def exact(self) -> Exact:
        """Its own modes."""
        n, zero = len(self.mass), np.zeros_like(self.mass)
        free = np.block([[zero, np.eye(n)], [-self.stiffness, -self.damping]])
        poles = eigvals(free, np.block([[np.eye(n), zero], [zero, self.mass]]))
        poles = poles[poles.imag > 0]
        return Exact(np.abs(poles) / 2 / np.pi, np.zeros(len(poles)), -poles.real / np.abs(poles))

    def frfs(self) -> ml.MeasuredFrf:
        """Noisy FRFs of both driven points."""
        hz = np.linspace(self.high_hz / LINES, self.high_hz, LINES)
        s = 2j * np.pi * hz
        # No two hits of a point land at one place: their mean is nearer to it.
        off = TOLERANCE.hit_position_m / np.sqrt(HITS) * self.rng.standard_normal((len(self.hits), 3))
        off[:, self.along :] = 0
        into = np.array(
            [
                self.row(np.minimum(self.places[p - 1] + d, self.places.max(0)), "z")
                for p, d in zip(self.hits, off, strict=True)
            ]
        )
        out = np.array([self.row(at, axis) for at in self.sensors for axis in self.axes])
        k = s[:, None, None] ** 2 * self.mass + s[:, None, None] * self.damping + self.stiffness
        frf = s[:, None, None] ** 2 * (out @ np.linalg.solve(k, np.broadcast_to(into.T, (LINES, *into.T.shape))))
        frf = frf * self.gain[None, :, None]
        noise = self.rng.standard_normal((2, *frf.shape)) * NOISE * np.sqrt(np.mean(np.abs(frf) ** 2, axis=0))
        frf = frf + (noise[0] + 1j * noise[1]) / np.sqrt(2)
        points = [p for p in range(1, len(self.places) + 1) for _ in self.axes]
        return ml.frf(hz, frf, inputs=list(self.hits), outputs=points)

    def identified(self, measured: ml.MeasuredFrf) -> ModalModel:
        """The model of FRFs."""
        found = ml.identify(measured, progress=False).modal_model
        shares = np.full((found.n_modes, len(self.hits), HITS), 1 / HITS)
        return found.model_copy(update={"outputs": tuple(c.name for c in self.rig.channels[1:]), "hit_shares": shares})


def rows_of(seed: int) -> list[list[object]]:
    """Predicted and measured modes of one bench."""
    bench = Bench(seed)
    kind, size, point, added = bench.drawn()
    other = bench.with_added(kind, size, point, added)
    before = bench.identified(bench.frfs())
    predicted = (
        KnownStructure(before, bench.rig.model_copy(update={"tolerance": TOLERANCE})).with_changes([added]).modes
    )
    return beside(kind, seed, size, point, before, predicted, other.exact())


if __name__ == "__main__":
    measure(rows_of, COLUMNS, summary, FIRST_SEED, int(sys.argv[1]), Path(sys.argv[2]))

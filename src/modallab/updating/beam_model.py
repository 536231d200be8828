"""The beam of a rig file as a model with parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.rig import Beam, Rig
from modallab.formats.fem.fem_file import FemModel
from modallab.formats.fem.matrix_model import MatrixModel
from modallab.modification.freedoms import Freedom
from modallab.twin.elements import shape_rows
from modallab.twin.matrices import OWN
from modallab.twin.modes import undamped_modes
from modallab.twin.structure import ROOT, TwinStructure, root_of_rig_file
from modallab.updating.elements import shapes_at
from modallab.updating.result import Prior

Predictor = Callable[[Mapping[str, float]], tuple[Real, Real]]
"""Numbers by name -> (modes,) Hz and (modes, freedoms) shapes at unit modal mass, kg^-1/2."""


LEAST_HZ = 1e-6


def predict_modes_of_matrices(model: MatrixModel, rig: Rig, freedoms: tuple[Freedom, ...]) -> Predictor:
    """The modes of matrices at the freedoms of a test.

    Args:
        model: with what its parameters change of it.
        rig: where the points are.
        freedoms: of the test.
    """
    return lambda numbers: shapes_at(FemModel(model.modes(numbers), dict(model.points)), rig, freedoms)


def checked_predictor(predict: Predictor, freedoms: int) -> Predictor:
    """A predictor that says what is wrong with what it is given.

    Raises:
        DataError: of the predictor: shapes that do not fit the frequencies or the freedoms, or no finite numbers.
    """

    def predicted(numbers: Mapping[str, float]) -> tuple[Real, Real]:
        hz, shapes = (np.asarray(a, np.float64) for a in predict(numbers))
        if hz.ndim != 1 or shapes.shape != (hz.size, freedoms):
            raise DataError(
                f"the model gives frequencies {hz.shape} and shapes {shapes.shape} for {freedoms} points",
                remedy="give (modes,) frequencies and (modes, points) shapes",
            )
        if not (np.isfinite(hz).all() and np.isfinite(shapes).all()):
            said = ", ".join(f"{name} {value:.4g}" for name, value in numbers.items())
            raise DataError(f"the model gives no finite modes at {said}", remedy="narrow the priors")
        # Of a motion of the whole, or of a spring below 0: logarithms are taken of all.
        return np.maximum(hz, LEAST_HZ), shapes

    return predicted


OF_BEAM = {"youngs_modulus": "Pa", "density": "kg/m^3", "thickness": "m"}
AT_ROOT = {"joint_rotation": "N m/rad", "joint_translation": "N/m"}
AT_POINTS = {"mass": "kg", "spring": "N/m"}
NAMES = f"{', '.join((*OF_BEAM, *AT_ROOT))}, mass@POINT or spring@POINT"


@dataclass(frozen=True, eq=False, slots=True)
class BeamModel:
    """Euler and Bernoulli's cantilever with rotary inertia.

    Parameters are `youngs_modulus`, `density`, `thickness`, the springs `joint_rotation` and `joint_translation` of
    its root, and `mass@8` or `spring@8` (to ground) at a point.

    Attributes:
        rig: with the beam and its points.
        freedoms: (freedoms,) at which shapes are asked for.
    """

    rig: Rig
    freedoms: tuple[Freedom, ...]

    @property
    def beam(self) -> Beam:
        """It as the rig file states it.

        Raises:
            DataError: it states none.
        """
        if self.rig.beam is None:
            raise DataError(
                "the rig file describes no beam", where=self.rig.name, remedy="name a finite-element model instead"
            )
        return self.rig.beam

    @property
    def priors(self) -> dict[str, Prior]:
        """What the rig file believes, with its tolerances."""
        beam, t = self.beam, self.rig.tolerance
        stated = (
            ("youngs_modulus", beam.youngs_modulus_pa, t.youngs_modulus),
            ("density", beam.density_kg_m3, t.density),
            ("thickness", beam.thickness_m, t.thickness),
        )
        found = {name: Prior(value, sigma, True, OF_BEAM[name]) for name, value, sigma in stated if sigma > 0}
        if root_of_rig_file(beam):
            spring = beam.bending_stiffness_n_m2 / (beam.length_m * root_of_rig_file(beam))
            found["joint_rotation"] = Prior(spring, ROOT, True, AT_ROOT["joint_rotation"])
        return found

    @staticmethod
    def unit_of(name: str) -> str:
        """SI unit of a parameter; "" of one that the beam does not have."""
        return (OF_BEAM | AT_ROOT | AT_POINTS).get(name.partition("@")[0], "")

    def __call__(self, numbers: Mapping[str, float]) -> tuple[Real, Real]:
        """(modes,) Hz and (modes, freedoms) shapes at unit modal mass.

        Raises:
            DataError: no such parameter or point, or a shape across the beam.
        """
        omega, phi, _ = undamped_modes(self._structure(numbers))
        x = np.array([self._place(point) for point, _ in self.freedoms])
        across = [f for f in self.freedoms if f[1] not in ("", self.rig.drive_direction[1])]
        if across:
            raise DataError(
                f"point {across[0][0]} moves along {across[0][1]}, across the beam's bending",
                remedy="name a finite-element model",
            )
        return omega / (2 * np.pi), (shape_rows(x, self.beam.length_m) @ phi[:OWN]).T

    def _structure(self, numbers: Mapping[str, float]) -> TwinStructure:
        s = TwinStructure.of(self.beam, self.rig.damping_ratio.guess)
        s = replace(
            s,
            youngs_modulus_pa=numbers.get("youngs_modulus", s.youngs_modulus_pa),
            density_kg_m3=numbers.get("density", s.density_kg_m3),
            thickness_m=numbers.get("thickness", s.thickness_m),
        )
        rest = {name: value for name, value in numbers.items() if name not in OF_BEAM}
        masses, springs = list(s.masses), list(s.springs)
        for name, value in rest.items():
            kind, _, point = name.partition("@")
            if name == "joint_rotation":
                s = replace(s, root_rotation=s.bending_stiffness / (s.length_m * value))
            elif name == "joint_translation":
                s = replace(s, root_translation=s.bending_stiffness / (s.length_m**3 * value))
            elif kind in AT_POINTS and point.isdecimal():
                (masses if kind == "mass" else springs).append((self._place(int(point)), value))
            else:
                raise DataError(f"the beam has no parameter {name!r}", remedy=f"use {NAMES}")
        return replace(s, masses=tuple(masses), springs=tuple(springs))

    def _place(self, point: int) -> float:
        for one in self.rig.points:
            if one.id == point:
                return one.x_m
        raise DataError(f"the rig has no point {point}", remedy="name one of its points")

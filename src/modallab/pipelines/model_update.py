"""A model of the structure corrected by a measured one: the beam of the rig, matrices, or a function."""

import runpy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.formats.fem.fem_file import FemParameter, read_matrix_model
from modallab.formats.fem.matrix_model import MASS, STIFFNESS, MatrixModel
from modallab.modification.known import KnownStructure
from modallab.updating.beam_model import BeamModel, Predictor, predict_modes_of_matrices
from modallab.updating.posterior import update_parameters
from modallab.updating.result import Prior, UpdatedParameters, measured_modes

PREDICT, PRIORS = "predict", "priors"
"""Names in a Python file that is a model."""


def update_model(
    known: KnownStructure,
    of: Path | MatrixModel | Callable[..., Any] | None = None,
    priors: Mapping[str, Prior] | None = None,
    held_out: Sequence[int] = (),
) -> UpdatedParameters:
    """The parameters of a model that measured modes leave possible.

    Factors on all stiffness and all mass are always free in matrices, as E and density are in the beam: what they
    explain is no local fault.

    Args:
        known: the measured structure.
        of: a file of matrices with parameters or a Python file; matrices; a function from numbers by name to
            frequencies (modes,) in Hz and shapes (modes, points) at unit modal mass; None for the rig's beam.
        priors: of parameters beside those that the model states, or instead of them.
        held_out: modes, from 1, that only check the estimate.

    Raises:
        DataError: no rig, no such parameter or mode, or a model without the points of the test.
        FormatError: the file holds no matrices and no function.
    """
    predict, stated = _matrix_model(known, of)
    given = {n: p if p.unit else replace(p, unit=_unit_of(n, of, stated)) for n, p in (priors or {}).items()}
    return update_parameters(predict, stated | given, measured_modes(known), held_out)


def _unit_of(name: str, of: object, stated: Mapping[str, Prior]) -> str:
    return BeamModel.unit_of(name) if of is None else stated[name].unit if name in stated else ""


def _matrix_model(
    known: KnownStructure, of: Path | MatrixModel | Callable[..., Any] | None
) -> tuple[Predictor, dict[str, Prior]]:
    freedoms = known.structure.freedoms
    if isinstance(of, Path) and of.suffix == ".py":
        return _predictor_of_file(of)
    if callable(of):
        return of, {}
    if of is None:
        beam = BeamModel(known.stated_rig, freedoms)
        return beam, beam.priors
    matrices, stated = read_matrix_model(of) if isinstance(of, Path) else (of, dict[str, FemParameter]())
    own = {name: Prior(p.value, p.sigma, unit=p.unit) for name, p in stated.items()}
    return predict_modes_of_matrices(matrices, known.stated_rig, freedoms), _whole_campaign(known.stated_rig) | own


def _whole_campaign(rig: Rig) -> dict[str, Prior]:
    t = rig.tolerance
    sizes = {STIFFNESS: np.hypot(t.youngs_modulus, 3 * t.thickness), MASS: np.hypot(t.density, t.thickness)}
    return {name: Prior(1.0, float(sigma), True) for name, sigma in sizes.items() if sigma > 0}


def _predictor_of_file(path: Path) -> tuple[Predictor, dict[str, Prior]]:
    if not path.is_file():
        raise FormatError("is not there, or no file", where=str(path), remedy="name a Python file with predict")
    held = runpy.run_path(str(path))
    if not callable(held.get(PREDICT)):
        raise FormatError(
            f"defines no function {PREDICT}", where=str(path), remedy="def predict(numbers): return hz, shapes"
        )
    return held[PREDICT], dict(held.get(PRIORS, {}))

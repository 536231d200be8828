"""What predicts modes from parameters: a function of numbers by name."""

from collections.abc import Callable, Mapping

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.fem.fem_file import FemModel
from modallab.formats.fem.matrix_model import MatrixModel
from modallab.modification.freedoms import Freedom
from modallab.updating.elements import shapes_at

Predictor = Callable[[Mapping[str, float]], tuple[Real, Real]]
"""Numbers by name -> (modes,) Hz and (modes, freedoms) shapes at unit modal mass, kg^-1/2."""


LEAST_HZ = 1e-6


def predictor_of_matrices(model: MatrixModel, rig: Rig, freedoms: tuple[Freedom, ...]) -> Predictor:
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

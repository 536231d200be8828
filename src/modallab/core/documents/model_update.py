"""A finite-element model corrected by a campaign's modal model."""

from typing import Annotated, Literal, Self

from pydantic import Field, PositiveInt, model_validator

from modallab.core.frozen import Frozen, RealArray, Truth
from modallab.core.units import Test

Finite = Annotated[float, Field(ge=-1e30, le=1e30, allow_inf_nan=False)]
Deviation = Annotated[float, Field(gt=0, le=1e30, allow_inf_nan=False)]
ROWS = 300
"""Of matrices: an estimate asks for their modes some hundred times."""
Matrix = Annotated[
    tuple[Annotated[tuple[Finite, ...], Field(max_length=ROWS)], ...], Field(min_length=1, max_length=ROWS)
]
Direction = Literal["x", "y", "z", "rx", "ry", "rz"]
Name = Annotated[str, Field(min_length=1, max_length=100)]


class PriorRequest(Frozen):
    """Prior of a parameter.

    Attributes:
        value: most probable value, in SI units.
        sigma: standard deviation; if relative, that of the logarithm, 0.05 for 5 %.
        relative: whether the parameter is positive with a relative deviation.
    """

    value: Finite
    sigma: Deviation
    relative: Truth = False


class MatrixParameterRequest(PriorRequest):
    """A parameter of matrices: the change of the matrices for one unit of it.

    Attributes:
        stiffness: (rows, rows) added to K; null for no change.
        mass: (rows, rows) added to M; null for no change.
    """

    stiffness: Matrix | None = None
    mass: Matrix | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.stiffness is None and self.mass is None:
            raise ValueError("changes neither stiffness nor mass")
        return self


class MatricesRequest(Frozen):
    """A finite-element model as matrices in SI units, at most 300 rows.

    Attributes:
        stiffness: (rows, rows) K in N/m.
        mass: (rows, rows) M in kg.
        freedoms: (rows,) node and direction of each row.
        places: node -> x, y and z in m; empty if nodes have the numbers of points.
        points: point of the rig -> node, where numbers and places do not determine it.
        parameters: parameters to correct, by name, besides factors on all stiffness and mass.
    """

    stiffness: Matrix
    mass: Matrix
    freedoms: Annotated[tuple[tuple[PositiveInt, Direction], ...], Field(min_length=1, max_length=ROWS)]
    places: dict[PositiveInt, tuple[Finite, Finite, Finite]] = Field(default_factory=dict)
    points: dict[PositiveInt, PositiveInt] = Field(default_factory=dict)
    parameters: Annotated[dict[Name, MatrixParameterRequest], Field(max_length=30)] = Field(default_factory=dict)


class UpdateRequest(Frozen):
    """Request to correct the parameters of a model by the test.

    Attributes:
        test: test of the modal model; null for the first.
        matrices: matrices of the model; null for the beam of the rig file.
        priors: priors of further parameters, or replacements of those of the model, such as spring@8 of the beam.
        held_out: numbers of modes, from 1, that only check the estimate.
    """

    test: Test | None = None
    matrices: MatricesRequest | None = None
    priors: Annotated[dict[Name, PriorRequest], Field(max_length=30)] = Field(default_factory=dict)
    held_out: Annotated[tuple[PositiveInt, ...], Field(max_length=100)] = ()


class ParameterView(Frozen):
    """A parameter before and after the test.

    Attributes:
        believed: most probable value before the test.
        found: most probable value after the test.
        interval: 95 % interval.
        unit: unit of all three values.
        determined: whether the test adds to the prior.
    """

    believed: float
    found: float
    interval: tuple[float, float]
    unit: str
    determined: bool


class UpdatedModelView(Frozen):
    """Parameters of a finite-element model estimated from measured modes.

    Attributes:
        parameters: parameters by name.
        together: pairs of parameters of which only a combination is known.
        held_out: modes, from 1, that the estimate did not use.
        measured_hz: (modes,).
        before_hz: (modes,) frequency of the model before the test.
        after_hz: (modes,) frequency with the estimate.
        mac_before: (modes,).
        mac_after: (modes,).
        notes: remarks on the numbers.
    """

    parameters: dict[str, ParameterView]
    together: tuple[tuple[str, str], ...]
    held_out: tuple[int, ...]
    measured_hz: RealArray
    before_hz: RealArray
    after_hz: RealArray
    mac_before: RealArray
    mac_after: RealArray
    notes: tuple[str, ...]

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


class PriorNew(Frozen):
    """What is believed of a parameter before the test.

    Attributes:
        value: most probable, in SI units.
        sigma: one standard deviation; of a relative one that of the logarithm, 0.05 for 5 %.
        relative: whether the parameter is positive and known by a share of itself.
    """

    value: Finite
    sigma: Deviation
    relative: Truth = False


class MatrixParameterNew(PriorNew):
    """A parameter of matrices: what one unit of it adds to them.

    Attributes:
        stiffness: (rows, rows) added to K; null for nothing.
        mass: (rows, rows) added to M; null for nothing.
    """

    stiffness: Matrix | None = None
    mass: Matrix | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.stiffness is None and self.mass is None:
            raise ValueError("changes neither stiffness nor mass")
        return self


class MatricesNew(Frozen):
    """A finite-element model as matrices in SI units, at most 300 rows.

    Attributes:
        stiffness: (rows, rows) K in N/m.
        mass: (rows, rows) M in kg.
        freedoms: (rows,) node and direction of each.
        places: node -> x, y and z in m; empty where nodes have the numbers of points.
        points: point of the rig -> node, where numbers and places do not say it.
        parameters: what the test may correct, by name, beside factors on all stiffness and mass.
    """

    stiffness: Matrix
    mass: Matrix
    freedoms: Annotated[tuple[tuple[PositiveInt, Direction], ...], Field(min_length=1, max_length=ROWS)]
    places: dict[PositiveInt, tuple[Finite, Finite, Finite]] = Field(default_factory=dict)
    points: dict[PositiveInt, PositiveInt] = Field(default_factory=dict)
    parameters: Annotated[dict[Name, MatrixParameterNew], Field(max_length=30)] = Field(default_factory=dict)


class UpdateNew(Frozen):
    """A model of the structure whose parameters the test shall correct.

    Attributes:
        test: whose modal model; null for the first.
        matrices: the model; null for the beam of the rig file.
        priors: of parameters beside those that the model states, or instead of them: of the beam such as spring@8.
        held_out: modes, from 1, that only check the estimate.
    """

    test: Test | None = None
    matrices: MatricesNew | None = None
    priors: Annotated[dict[Name, PriorNew], Field(max_length=30)] = Field(default_factory=dict)
    held_out: Annotated[tuple[PositiveInt, ...], Field(max_length=100)] = ()


class ParameterView(Frozen):
    """A parameter as it was believed and as it was found.

    Attributes:
        believed: most probable before the test.
        found: most probable with it.
        interval: 95 %.
        unit: of all three.
        determined: whether the test says more of it than was believed.
    """

    believed: float
    found: float
    interval: tuple[float, float]
    unit: str
    determined: bool


class UpdatedModelView(Frozen):
    """Parameters of a finite-element model estimated from measured modes.

    Attributes:
        parameters: by name.
        together: pairs of which only a combination is known.
        held_out: modes, from 1, that the estimate did not see.
        measured_hz: (modes,).
        before_hz: (modes,) of the model with what was believed.
        after_hz: (modes,) with the estimate.
        mac_before: (modes,).
        mac_after: (modes,).
        notes: what the numbers do not say.
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

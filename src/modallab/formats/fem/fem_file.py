"""A finite-element model as its owner gives it: a result file alone, or a YAML file that says what belongs to it."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self, cast

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import Field, PositiveInt, ValidationError, model_validator

from modallab.core.errors import DataError, FormatError
from modallab.core.frozen import Frozen
from modallab.formats.fem.calculix import read_calculix
from modallab.formats.fem.matrix_model import DIRECTIONS, READ, MatrixModel, holds, read_matrix
from modallab.formats.fem.nastran import read_nastran
from modallab.formats.fem.nastran_op2 import read_op2
from modallab.formats.fem.uff_modes import read_uff_modes
from modallab.formats.modes import NodeModes, Units, in_si

K, M, FREEDOMS, NODES = ("K", "stiffness"), ("M", "mass"), ("freedoms", "dof"), ("nodes",)
RESULTS = {
    ".frd": read_calculix,
    ".f06": read_nastran,
    ".pch": read_nastran,
    ".op2": read_op2,
    ".uff": read_uff_modes,
    ".unv": read_uff_modes,
}
DESCRIBED = (".yaml", ".yml")
EXAMPLE = "{stiffness: K.mtx, mass: M.mtx, freedoms: freedoms.csv, nodes: nodes.csv} or {results: plate.frd, units: mm}"
_REMEDY = f"name a result file ({', '.join(RESULTS)}), matrices (.npz, .mat), or a YAML file such as {EXAMPLE}"


class FemParameter(Frozen):
    """A parameter of matrices, and what is believed of it; files are named beside this one.

    Attributes:
        stiffness: what one unit of it adds to K.
        mass: what one unit of it adds to M.
        value: most probable, in the unit of the matrices.
        sigma: one standard deviation.
        unit: in words.
    """

    stiffness: str = ""
    mass: str = ""
    value: Annotated[float, Field(allow_inf_nan=False)] = 0.0
    sigma: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    unit: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not (self.stiffness or self.mass):
            raise ValueError("names neither stiffness nor mass")
        return self


class FemFile(Frozen):
    """What belongs to a model; files are named beside this one.

    Attributes:
        results: modes of CalculiX (.frd), Nastran (.f06, .pch, .op2) or a universal file.
        stiffness: K instead: Matrix Market, NumPy, SciPy or MATLAB.
        mass: M.
        freedoms: node and direction (x, y, z, rx, ry, rz or 1 to 6) of each row of the matrices.
        nodes: number, x, y and z of each node.
        units: of length; mm goes with tonnes.
        points: node of a point of the rig, where numbers and places do not say it.
        damping_ratio: of every mode; None: what the rig file believes.
        parameters: what a test may correct, by name.
    """

    results: str = ""
    stiffness: str = ""
    mass: str = ""
    freedoms: str = ""
    nodes: str = ""
    units: Units = "m"
    points: dict[int, PositiveInt] = Field(default_factory=dict)
    damping_ratio: Annotated[float, Field(gt=0, lt=1)] | None = None
    parameters: dict[str, FemParameter] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.results and self.parameters:
            raise ValueError("parameters need matrices: results alone do not say what a parameter changes")
        if bool(self.results) == bool(self.stiffness or self.mass):
            raise ValueError("names neither or both of results and matrices")
        if not self.results and not (self.stiffness and self.mass and self.freedoms):
            raise ValueError("matrices need stiffness, mass and freedoms")
        return self


@dataclass(frozen=True, eq=False, slots=True)
class FemModel:
    """Modes of a model in SI units, and the node of each point that its owner has named."""

    modes: NodeModes
    points: dict[int, int]


def is_fem(path: Path) -> bool:
    """Whether a file, by its ending, is a model and no campaign."""
    return path.suffix.lower() in (*RESULTS, *DESCRIBED) or holds(path, K)


def read_fem(path: Path) -> FemModel:
    """The modes of a model.

    Raises:
        FormatError: a file cannot be read, or the description says what it must not.
        DataError: a file holds no modes, or matrices that do not belong together.
    """
    if not path.is_file():
        raise FormatError("is not there, or no file", where=str(path), remedy=_REMEDY)
    ending = path.suffix.lower()
    if ending in RESULTS:
        return FemModel(RESULTS[ending](path), {})
    if ending in DESCRIBED:
        return _described(path)
    if holds(path, K):
        return FemModel(_of_one_file(path).modes({}), {})
    raise FormatError(f"is no model: its ending is {ending or 'missing'}", where=str(path), remedy=_REMEDY)


def read_matrix_model(path: Path) -> tuple[MatrixModel, dict[str, FemParameter]]:
    """A model of matrices, and what its file believes of its parameters.

    Raises:
        FormatError: a file cannot be read, or it holds no matrices.
        DataError: matrices that do not belong together.
    """
    if path.is_file() and path.suffix.lower() in DESCRIBED:
        description = _description(path)
        if not description.results:
            return _matrices_of(path, description), description.parameters
    elif path.is_file() and holds(path, K):
        return _of_one_file(path), {}
    raise FormatError("holds no matrices", where=str(path), remedy=f"name {', '.join(READ)}, or such as {EXAMPLE}")


def _described(path: Path) -> FemModel:
    description = _description(path)
    if description.results:
        modes = in_si(read_fem(path.parent / description.results).modes, description.units)
    else:
        modes = _matrices_of(path, description).modes({})
    if description.damping_ratio is not None:
        modes = replace(modes, damping_ratio=np.full(modes.frequency_hz.size, description.damping_ratio))
    return FemModel(modes, dict(description.points))


def _matrices_of(path: Path, description: FemFile) -> MatrixModel:
    here, believed = path.parent, description.parameters
    stiff, heavy = here / description.stiffness, here / description.mass
    whole = _of_matrices(
        stiff, heavy, here / description.freedoms, here / description.nodes if description.nodes else None
    )
    return replace(
        whole,
        stiffness_slopes={n: read_matrix(here / p.stiffness, K) for n, p in believed.items() if p.stiffness},
        mass_slopes={n: read_matrix(here / p.mass, M) for n, p in believed.items() if p.mass},
        points=description.points,
        units=description.units,
    )


def _description(path: Path) -> FemFile:
    try:
        return FemFile.model_validate(yaml.safe_load(path.read_text(encoding="utf-8-sig")))
    except ValidationError as error:
        found = "; ".join(_fault(cast("Any", one)) for one in error.errors())
        raise FormatError(found, where=str(path), remedy=f"write it such as {EXAMPLE}") from error
    except (OSError, ValueError, yaml.YAMLError) as error:
        first = str(error).partition("\n")[0]
        raise FormatError(f"is no YAML: {first}", where=str(path), remedy=f"write it such as {EXAMPLE}") from error


def _fault(error: dict[str, Any]) -> str:
    place = ".".join(map(str, error["loc"]))
    if error["type"] == "extra_forbidden":
        return f"{place} is no field of a model; there are {', '.join(FemFile.model_fields)}"
    message = str(error["msg"]).removeprefix("Value error, ")
    return f"{place}: {message}" if place else message


def _of_one_file(path: Path) -> MatrixModel:
    return _of_matrices(path, path, path, path if holds(path, NODES) else None)


def _of_matrices(stiffness: Path, mass: Path, freedoms: Path, nodes: Path | None) -> MatrixModel:
    rows = [(int(node), int(direction)) for node, direction in _table(freedoms, FREEDOMS, 2)]
    places = {int(n): (float(x), float(y), float(z)) for n, x, y, z in (_table(nodes, NODES, 4) if nodes else ())}
    return MatrixModel(read_matrix(stiffness, K), read_matrix(mass, M), rows, places=places, title=stiffness.stem)


def _table(path: Path, names: tuple[str, ...], columns: int) -> NDArray[np.float64]:
    """(rows, columns) numbers of a text table, or of an array."""
    if path.suffix in (".npz", ".npy", ".mat"):
        found = np.asarray(read_matrix(path, names), np.float64)
    else:
        found = _text_table(path)
    if found.ndim != 2 or found.shape[1] != columns:
        raise DataError(
            f"the table {names[0]} has shape {found.shape}, and {columns} columns are asked for",
            where=str(path),
            remedy="a row for each row of the matrices: node, direction"
            if columns == 2
            else "a row a node: id, x, y, z",
        )
    return found


def _text_table(path: Path) -> NDArray[np.float64]:
    try:
        lines = (line.partition("#")[0].replace(",", " ").split() for line in path.read_text("utf-8-sig").splitlines())
        rows = [[float(DIRECTIONS.get(cell.lower(), cell)) for cell in cells] for cells in lines if cells]
        return np.array(rows, np.float64)
    except (OSError, ValueError) as error:
        raise FormatError(
            f"is no table of numbers: {error}", where=str(path), remedy="write node and direction, or node, x, y and z"
        ) from error

"""Which outputs and driven points of two models are the same: by place and axis, not by the name of a channel."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.gap.modal.off_axis import MeasuredFrfs
from modallab.modification.freedoms import Freedom, freedoms_of, output_signs, with_points
from modallab.modification.shapes import shapes_of

REACH = 3.0
"""Deviations of a sensor's place within which two points are the same."""
EXTENT = 1e-3
"""The same over the structure's extent, where that is more: places are rounded."""


@dataclass(frozen=True, eq=False, slots=True)
class Side:
    """One side of a comparison.

    Attributes:
        model: modal.
        measured: FRFs that it was identified from; None where they are not known.
    """

    model: ModalModel
    measured: MeasuredFrfs | None = None


def in_common(reference: Side, own: Rig, bench: Side, rig: Rig) -> tuple[Side, Side]:
    """Both on the freedoms that both have, positive along the bench's freedoms, with the bench's names.

    Args:
        reference: of the rig `own`.
        own: its rig; the bench's where it has none.
        bench: of the rig `rig`.
        rig: the bench's.

    Raises:
        DataError: they share no output or no driven point, or several shakers drove the bench at once.
    """
    points = _points(own, rig)
    there, here = with_points(reference.model, own), with_points(bench.model, rig)
    outputs, inputs = ([(points.get(p, -p), axis) for p, axis in of] for of in freedoms_of(there, own))
    alone = here.operating_shapes is not None
    if alone:
        here = _driven_at(here, next((f[0] for f in inputs if f in outputs), None))
    wanted, driven = freedoms_of(here, rig)
    if inputs and not set(driven) & set(inputs):
        reference = Side(_driven_where_seen(there, own, [o for o, f in enumerate(outputs) if f in driven]))
        there = reference.model
        inputs = [outputs[o] for o in range(len(outputs)) if outputs[o] in driven][: len(there.input_points)]
    rows = [o for o, f in enumerate(wanted) if f in outputs]
    columns = [i for i, f in enumerate(driven) if f in inputs and f not in driven[:i]]
    _require(rows, columns, here, rig)
    found = _chosen(replace(bench, model=here), rows, columns, output_signs(here, rig))
    same = [_named(there.outputs, outputs, here.outputs[o], wanted[o]) for o in rows]
    # A motion along the drive is positive along it, as the force is: where the drives are opposite, both are.
    opposite = -1.0 if own.drive_direction[0] != rig.drive_direction[0] else 1.0
    along = np.array([opposite if axis == rig.drive_direction[1] else 1.0 for _, axis in outputs])
    turned = output_signs(there, own) * along * opposite
    known = _chosen(replace(reference, model=there), same, [inputs.index(driven[i]) for i in columns], turned)
    names = {n: getattr(found.model, n) for n in ("outputs", "output_points", "input_points")}
    known = replace(known, model=known.model.model_copy(update=names))
    return _of_responses(known.model, found.model) if alone else (known, found)


def _driven_at(model: ModalModel, point: int | None) -> ModalModel:
    """A model of responses alone as if a force at a point had made them, without a scale; as it is without a point."""
    if point is None or model.operating_shapes is None:
        return model
    shapes = model.operating_shapes[:, :, None]
    sigma = np.zeros(shapes.shape) if model.operating_shape_sigma is None else model.operating_shape_sigma[:, :, None]
    changed = {"modal_constants": shapes, "modal_constant_sigma": sigma, "input_points": (point,)}
    return model.model_copy(update={**changed, "residuals": np.zeros((0, shapes.shape[1], 1))})


def _of_responses(reference: ModalModel, bench: ModalModel) -> tuple[Side, Side]:
    """Shapes of a bench without a scale, each with that of the most similar one of a reference (MAC); modes alone."""
    mine, theirs = bench.modal_constants[:, :, 0], reference.modal_constants[:, :, 0]
    products, power = mine.conj() @ theirs.T, np.sum(np.abs(mine) ** 2, axis=1)
    likest = np.argmax(np.abs(products) / np.linalg.norm(theirs, axis=1), axis=1)
    scale = (products[np.arange(len(mine)), likest] / power)[:, None, None]
    sigma = bench.modal_constant_sigma * np.abs(scale)
    scaled = bench.model_copy(update={"modal_constants": bench.modal_constants * scale, "modal_constant_sigma": sigma})
    # What lies outside the band depends on the force.
    bare = reference.model_copy(update={"residuals": bench.residuals, "residual_powers": ()})
    return Side(bare), Side(scaled)


def _driven_where_seen(model: ModalModel, rig: Rig, rows: Sequence[int]) -> ModalModel:
    """The same driven at some of its outputs instead: by reciprocity, as far as its modes go; as it is without a scale.

    Of what lies outside the band the sensors of other points say nothing.
    """
    shapes, outputs = shapes_of(model, rig), freedoms_of(model, rig)[0]
    at = [shapes.index(f) for f in outputs]
    into = shapes.turn * shapes.driven[:, [at[o] for o in rows]]
    sigma = model.modal_constant_sigma.mean(axis=2, keepdims=True)
    return model.model_copy(
        update={
            "input_points": tuple(model.output_points[o] for o in rows) if shapes.scaled else (),
            "modal_constants": shapes.seen[:, at, None] * into[:, None] if shapes.scaled else into[:, None, :0],
            "modal_constant_sigma": np.repeat(sigma, len(rows), axis=2),
            "residuals": np.zeros((0, len(at), len(rows))),
            "residual_powers": (),
        }
    )


def _require(rows: Sequence[int], columns: Sequence[int], bench: ModalModel, rig: Rig) -> None:
    if not rows or not columns:
        raise DataError(
            "reference and bench share no output or no driven point",
            where=rig.name,
            remedy="measure both at the same points and along the same axes",
        )
    if bench.test in BROADBAND and len(columns) > 1:
        raise DataError(
            f"{len(columns)} shakers drove the bench at once, and a comparison knows the gain of one force alone",
            where=rig.name,
            remedy="compare a test of one shaker (shakers: first), or one with a hammer",
        )


def _named(names: Sequence[str], freedoms: Sequence[Freedom], name: str, freedom: Freedom) -> int:
    """The output at a freedom; of several the one of that name."""
    there = [o for o, f in enumerate(freedoms) if f == freedom]
    return next((o for o in there if names[o] == name), there[0])


def _chosen(side: Side, rows: list[int], columns: list[int], turns: Real) -> Side:
    """Some outputs and inputs, each output turned by its sign (outputs,)."""
    turned, model = turns[rows, None], side.model
    chosen = model.model_copy(
        update={
            "outputs": tuple(model.outputs[r] for r in rows),
            "output_points": tuple(model.output_points[r] for r in rows),
            "input_points": tuple(model.input_points[c] for c in columns),
            "modal_constants": model.modal_constants[:, rows][:, :, columns] * turned,
            "modal_constant_sigma": model.modal_constant_sigma[:, rows][:, :, columns],
            "residuals": model.residuals[:, rows][:, :, columns] * turned,
        }
    )
    return Side(chosen, None if side.measured is None else side.measured.chosen(rows, columns, turned))


def _points(own: Rig, rig: Rig) -> Mapping[int, int]:
    """Point of the one rig -> point of the other at the same place; of the same number where one says no places."""
    places, there = _places(own), _places(rig)
    if own == rig or not _apart(places) or not _apart(there):
        return {p: p for p in places}
    extent = float(np.ptp(np.array(list(there.values())), axis=0).max())
    reach = max(REACH * rig.tolerance.position_m, EXTENT * extent)
    found: dict[int, int] = {}
    for point, at in places.items():
        away = {p: float(np.linalg.norm(at - other)) for p, other in there.items()}
        nearest = point if away.get(point, np.inf) <= reach else min(away, key=lambda p: away[p])
        if away[nearest] <= reach:
            found[point] = nearest
    return found


def _places(rig: Rig) -> dict[int, Real]:
    return {p.id: np.array([p.x_m, p.y_m, p.z_m]) for p in rig.points}


def _apart(places: Mapping[int, Real]) -> bool:
    return len(places) > 1 and bool(np.any(np.ptp(np.array(list(places.values())), axis=0) > 0))

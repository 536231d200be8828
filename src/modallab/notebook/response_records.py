"""Responses to a force that nobody measured, as arrays."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from modallab.core.array_checks import check_rate, check_signals
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Point, Rig
from modallab.core.units import SI_UNIT, Quantity
from modallab.notebook.recording import Recording


def responses(
    y: ArrayLike,
    rate_hz: float,
    points: Sequence[int] | None = None,
    names: Sequence[str] | None = None,
    quantity: Quantity = "acceleration",
) -> Recording:
    """Responses to a random force that was not measured, for `ml.identify`.

    Args:
        y: (outputs, samples) in SI, one record.
        rate_hz: sampling rate.
        points: number of the point of each response; without them they are numbered from 1.
        names: of the responses; without them y1, y2, ...
        quantity: acceleration, velocity or displacement.

    Raises:
        DataError: no record of real numbers, or points or names of another number.
    """
    samples = np.atleast_2d(np.asarray(y))
    if samples.dtype.kind in "iuf":
        samples = np.ascontiguousarray(samples, np.float64)
    at = tuple(range(1, len(samples) + 1)) if points is None else tuple(int(p) for p in points)
    called = tuple(f"y{p}" for p in at) if names is None else tuple(names)
    for what, given in (("points", at), ("names", called)):
        if len(given) != len(samples) or len(set(given)) < len(given):
            raise DataError(
                f"{what}={list(given)} for {len(samples)} responses",
                remedy=f"give {len(samples)} different {what}, in the order of y",
            )
    check_signals(samples, called, "y")
    channels = tuple(
        Channel(index=i, name=name, quantity=quantity, unit=SI_UNIT[quantity], point=point)
        for i, (name, point) in enumerate(zip(called, at, strict=True))
    )
    places = tuple(Point(id=p, x_m=float(p)) for p in sorted(at))
    rig = Rig(name="responses from arrays", model="unknown", points=places, channels=channels)
    block = Block(
        name="responses",
        test="random",
        order=0,
        rate_hz=check_rate(rate_hz, "y"),
        samples=samples,
        scale=np.ones(len(samples)),
        units=tuple(c.unit for c in channels),
        channels=called,
    )
    return Recording(Campaign(rig, (block,), source="arrays"))

"""Custom scales, as they are saved: from what is measured to what a channel gives."""

from collections.abc import Callable

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.max_config import Section
from modallab_simulators.ni_daqmx_server.status import StatusError


def numbers(text: str) -> list[float]:
    """Numbers of a list as it is saved."""
    return [float(part) for part in text.split(",") if part.strip()]


def scaling(saved: dict[str, Section], name: str) -> Callable[[Floats], Floats]:
    """The function of a scale.

    Raises:
        StatusError: there is no such scale.
    """
    if name not in saved:
        raise StatusError(status.NO_SUCH_SCALE, f"Custom Scale: {name}")
    section = saved[name]
    kind = section["ScaleType"]
    if kind == "Linear":
        slope, first = float(section["Lin.Slope"]), float(section["Lin.YIntercept"])
        return lambda values: slope * values + first
    if kind == "Polynomial":
        coefficients = numbers(section["Poly.ForwardCoeff"])
        return lambda values: np.asarray(np.polynomial.polynomial.polyval(values, coefficients), np.float64)
    if kind == "Map Ranges":
        before = [float(section["Map.PreScaledMin"]), float(section["Map.PreScaledMax"])]
        after = [float(section["Map.ScaledMin"]), float(section["Map.ScaledMax"])]
        return lambda values: after[0] + (values - before[0]) * (after[1] - after[0]) / (before[1] - before[0])
    known, given = numbers(section["Table.PreScaledVals"]), numbers(section["Table.ScaledVals"])
    return lambda values: np.interp(values, known, given)

"""What each kind of job may be asked, checked before it is ordered and again before it begins."""

import json
from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, JsonValue, ValidationError

from modallab.core.errors import JobError
from modallab.core.frozen import Frozen
from modallab.core.model import Method
from modallab.core.units import Test
from modallab.identification.options import Options

Hertz = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class IdentifyParameters(Frozen):
    """How to identify: as `modallab identify` has it.

    Attributes:
        method: the estimator.
        band_hz: (low, high); None for the whole band in which the data have content.
        max_order: highest polynomial order, or number of states; None for one that suits the data.
        test: only this test.
        refine: whether its poles begin a maximum-likelihood search; None for what is usual with the method.
    """

    method: Method = "plscf"
    band_hz: tuple[Hertz, Hertz] | None = None
    max_order: Annotated[int, Field(ge=1, le=400)] | None = None
    test: Test | None = None
    refine: bool | None = None

    def options(self) -> Options:
        """For the identification."""
        return Options(method=self.method, band_hz=self.band_hz, max_order=self.max_order, refine=self.refine)


class ReportParameters(IdentifyParameters):
    """As for identify, and the heading; "" for one that names the rig."""

    title: Annotated[str, Field(max_length=200)] = ""


class DiagnoseParameters(Frozen):
    """Which records no fit may see, as `modallab gap diagnose --hold-out` has it."""

    hold_out: Annotated[str, Field(pattern=r"^(mixed|point:\d+|level:.+|test:impact|test:sine|last:[\d.]+)$")] = "mixed"


PARAMETERS: dict[str, type[Frozen]] = {
    "identify": IdentifyParameters,
    "report": ReportParameters,
    "diagnose": DiagnoseParameters,
}
"""Kind -> its parameters."""


def parse_parameters(kind: str, given: Mapping[str, JsonValue]) -> Frozen:
    """The parameters of a kind.

    Raises:
        JobError: no such kind, or parameters it does not have or whose values are wrong; all in one message.
    """
    if kind not in PARAMETERS:
        raise JobError(f"there is no kind {kind!r}", where="kind", remedy=f"ask for one of {', '.join(PARAMETERS)}")
    try:
        return PARAMETERS[kind].model_validate_json(json.dumps(dict(given)))
    except ValidationError as error:
        wrong = "; ".join(f"{'.'.join(map(str, e['loc'])) or kind}: {e['msg']}" for e in error.errors())
        raise JobError(
            f"wrong parameters: {wrong}",
            where=kind,
            remedy=f"{kind} has {', '.join(PARAMETERS[kind].model_fields)}",
        ) from error

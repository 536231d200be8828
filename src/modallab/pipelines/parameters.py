"""What each kind of job may be asked, checked before it is ordered and again before it begins."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import AfterValidator, Field, JsonValue, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from modallab.blind.request import BlindRequest
from modallab.core.block import Campaign
from modallab.core.errors import IdentificationError, JobError, PlanError
from modallab.core.field_errors import error_sentences
from modallab.core.frozen import Frozen, is_not_stated
from modallab.core.hold_out import HoldOut
from modallab.core.units import FrfEstimator, Test
from modallab.identification.estimator import USUAL, estimator_names, find_estimator
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod

if TYPE_CHECKING:
    from modallab.pipelines.identify import CampaignResult

Hertz = Annotated[float, Field(ge=0, allow_inf_nan=False)]


def _check_estimator(name: str) -> str:
    names = [repr(known) for known in estimator_names()]
    if repr(name) not in names:
        listed = " or ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        raise PydanticCustomError("estimator", "Input should be {names}", {"names": listed})
    return name


def _check_hold_out(text: str) -> str:
    try:
        return str(HoldOut.parse(text))
    except PlanError as error:
        raise PydanticCustomError("hold_out", "{why}", {"why": str(error)}) from error


class IdentifyParameters(Frozen):
    """How to identify: as `modallab identify` has it.

    Attributes:
        method: the estimator.
        band_hz: (low, high); None for the whole band in which the data have content.
        max_order: highest order of an estimator that has one, within its limits; None for one that suits the data.
        test: only this test.
        pick_hz: if given, these modes and no others.
        frf: H1, H2 or Hv: how FRFs are made of blocks of random drives and chirps, and of several hits at each point.
        refine: whether its poles begin a maximum-likelihood search; None for what is usual with the method.
        response_only: whether the responses alone are identified, to a random force; None for where none was measured.
            Of the others only band_hz and test go with it.
        response_method: how modes of the responses alone are found.
    """

    method: Annotated[str, AfterValidator(_check_estimator)] = USUAL
    band_hz: tuple[Hertz, Hertz] | None = None
    max_order: Annotated[int, Field(ge=1)] | None = None
    test: Test | None = None
    refine: bool | None = None
    pick_hz: Annotated[tuple[Annotated[float, Field(gt=0, allow_inf_nan=False)], ...], Field(max_length=100)] = Field(
        default=(), exclude_if=is_not_stated
    )
    frf: FrfEstimator = Field(default="H1", exclude_if=lambda estimator: estimator == "H1")
    response_only: bool | None = Field(default=None, exclude_if=is_not_stated)
    response_method: ResponseMethod = Field(default=USUAL_RESPONSE, exclude_if=lambda method: method == USUAL_RESPONSE)

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        order = find_estimator(self.method).order
        if order is not None and self.max_order is not None:
            try:
                order.check(self.max_order)
            except IdentificationError as error:
                raise PydanticCustomError("max_order", "max_order: {why}", {"why": str(error)}) from error
        return self

    @model_validator(mode="after")
    def _check_alone(self) -> Self:
        given = self.model_fields_set - {"response_only", "response_method", "band_hz", "test", "title"}
        named = [name for name in sorted(given) if getattr(self, name) != type(self).model_fields[name].default]
        if self.response_only and named:
            raise PydanticCustomError(
                "response_only", "response_only cannot be combined with {named}", {"named": ", ".join(named)}
            )
        return self

    def identify(self, campaign: Campaign) -> "CampaignResult":
        """What a campaign gives, asked so.

        Raises:
            ModallabError: there is nothing to identify, or no mode.
        """
        # Not above: who only orders a job needs none of it.
        from modallab.pipelines.response_only import identify_chosen

        return identify_chosen(
            campaign,
            self.options(),
            self.test,
            response_only=self.response_only,
            method=self.response_method,
        )

    def options(self) -> IdentificationOptions:
        """For the identification."""
        return IdentificationOptions(
            method=self.method,
            band_hz=self.band_hz,
            max_order=self.max_order,
            refine=self.refine,
            pick_hz=self.pick_hz,
            frf=self.frf,
        )


class ReportParameters(IdentifyParameters):
    """As for identify, and the heading; "" for one that names the rig."""

    title: Annotated[str, Field(max_length=200)] = ""


class DiagnoseParameters(Frozen):
    """As `modallab gap diagnose` has it.

    Attributes:
        hold_out: records no fit may see; of a beam.
        reference: of the job's runs those from before. The modal model that they give stands for the simulation, of
            any structure.
        band_hz: (low, high) in which both are identified, with a reference; None for the whole band.
    """

    hold_out: Annotated[str, AfterValidator(_check_hold_out)] = "mixed"
    reference: tuple[str, ...] = Field(default=(), exclude_if=is_not_stated)
    band_hz: tuple[Hertz, Hertz] | None = Field(default=None, exclude_if=is_not_stated)

    @model_validator(mode="after")
    def _check_band(self) -> Self:
        if self.band_hz is not None and not self.reference:
            raise PydanticCustomError("band_hz", "band_hz needs a reference")
        return self

    def runs_by_session(self, inputs: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The runs that are diagnosed, and those from before.

        Raises:
            JobError: a run from before is not among the job's, or no other is.
        """
        foreign = [run for run in self.reference if run not in inputs]
        today = tuple(run for run in inputs if run not in self.reference)
        if foreign or not today:
            found = f"{foreign[0]!r} is not among the runs" if foreign else "all runs are earlier ones"
            raise JobError(found, where="reference", remedy="name present and earlier runs in `runs`")
        return today, self.reference


class EstimateParameters(Frozen):
    """Which blocks of a run that is on: `as_of` changes whenever others count, so that they are looked at again."""

    as_of: Annotated[str, Field(pattern="^[0-9a-f]{0,64}$")] = ""


class BlindParameters(BlindRequest):
    """As `modallab gap blind`; a job computes them one after another, so that there may be fewer."""

    trials: Annotated[int, Field(ge=0, le=200)] = 6
    none: Annotated[int, Field(ge=0, le=200)] = 2
    pairs: Annotated[int, Field(ge=0, le=200)] = 0


PARAMETERS: dict[str, type[Frozen]] = {
    "identify": IdentifyParameters,
    "report": ReportParameters,
    "diagnose": DiagnoseParameters,
    "estimate": EstimateParameters,
    "blind": BlindParameters,
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
        wrong = "; ".join(error_sentences(error))
        raise JobError(
            f"wrong parameters: {wrong}",
            where=kind,
            remedy=f"{kind} has {', '.join(PARAMETERS[kind].model_fields)}",
        ) from error

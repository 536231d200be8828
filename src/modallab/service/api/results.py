"""Models, comparisons and diagnoses as resources of campaigns and runs."""

from typing import Annotated

from fastapi import Query

from modallab.core.documents.models import ComparisonView, CurvesView, DiagnosisView, ModelsView
from modallab.core.documents.pages import Page
from modallab.core.documents.results import JobView
from modallab.service.api.jobs import job_in_list
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router
from modallab.service.jobs.results import (
    comparison_of_runs,
    curves_of_campaign,
    diagnosis_of_campaign,
    jobs_of_run,
    models_of_campaign,
    models_of_run,
)

router = make_router("results")
Run = Annotated[str, Query(max_length=64, description="A run with a model.")]


@router.get("/campaigns/{campaign}/model", responses=documented_responses(404))
def get_campaign_model(campaign: str, service: ServiceOf) -> ModelsView:
    """The newest model of every test of a campaign, whichever job computed it.

    `current` says whether the blocks they were computed from still are those that count.
    """
    return models_of_campaign(service, campaign)


@router.get("/runs/{run}/model", responses=documented_responses(404))
def get_run_model(run: str, service: ServiceOf) -> ModelsView:
    """The newest model of a run."""
    return models_of_run(service, run)


@router.get("/runs/{run}/jobs", responses=documented_responses(404))
def list_run_jobs(run: str, service: ServiceOf) -> Page[JobView]:
    """The jobs of a run, the newest first."""
    return Page(items=tuple(job_in_list(job) for job in jobs_of_run(service, run)))


@router.get("/campaigns/{campaign}/curves", responses=documented_responses(404))
def get_curves(campaign: str, service: ServiceOf) -> CurvesView:
    """Curves of the newest models of a campaign: measured and regenerated mobility, stabilisation diagram."""
    return curves_of_campaign(service, campaign)


@router.get("/campaigns/{campaign}/gap", responses=documented_responses(404))
def get_campaign_gap(campaign: str, service: ServiceOf) -> DiagnosisView:
    """The newest diagnosis of a campaign as data; as a page at `/campaigns/{campaign}/diagnosis`."""
    return diagnosis_of_campaign(service, campaign)


@router.get("/comparison", responses=documented_responses(404))
def compare_runs(one: Run, other: Run, service: ServiceOf) -> ComparisonView:
    """Comparison of the models of two runs: frequencies, damping, MAC of the shapes."""
    return comparison_of_runs(service, one, other)

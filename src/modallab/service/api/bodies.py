"""Bodies of requests, each with an example for whoever reads the API or tries it."""

from typing import Annotated

from fastapi import Body
from fastapi.openapi.models import Example

from modallab.core.documents.campaigns import CampaignChange, CampaignNew
from modallab.core.documents.results import JobNew
from modallab.core.documents.rigs import LeaseNew, StopReason
from modallab.core.documents.runs import Command, RunNew, Verdict

NewCampaign = Annotated[
    CampaignNew,
    Body(openapi_examples={"session": Example(value={"name": "first session", "rig": "link", "note": "new clamp"})}),
]
ChangedCampaign = Annotated[
    CampaignChange, Body(openapi_examples={"rename": Example(value={"name": "second session"})})
]
NewLease = Annotated[
    LeaseNew, Body(openapi_examples={"for ten minutes": Example(value={"operator": "Ada", "ttl_s": 600})})
]
NewRun = Annotated[
    RunNew,
    Body(
        openapi_examples={
            "impact test": Example(value={"plan": {"kind": "impact", "points": [10, 6, 3], "hits": 5}}),
            "sine test": Example(value={"plan": {"kind": "sine", "frequencies_hz": [20.0, 40.0]}}),
        }
    ),
]
RunCommand = Annotated[
    Command,
    Body(
        openapi_examples={
            "pause": Example(value={"kind": "pause"}),
            "repeat one frequency": Example(value={"kind": "repeat", "frequency_hz": 20.0}),
            "drop one hit": Example(value={"kind": "drop", "n": 3, "reason": "hit beside the point"}),
        }
    ),
]
Judgement = Annotated[
    Verdict, Body(openapi_examples={"reject": Example(value={"accepted": False, "reason": "someone walked by"})})
]
NewJob = Annotated[
    JobNew | None,
    Body(
        openapi_examples={"with its settings": Example(value={"parameters": {"title": "Report of the first session"}})}
    ),
]
Reason = Annotated[StopReason | None, Body(openapi_examples={"why": Example(value={"reason": "loose cable"})})]

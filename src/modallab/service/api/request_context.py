"""What every route has at hand: the service, its settings, and who asks."""

from typing import Annotated

from fastapi import Depends, Header, Request

from modallab.core.settings import Settings
from modallab.service.context import Service

OPERATOR = "Modallab-Operator"
_NO_CONTROL = r"^[^\x00-\x1f\x7f]+$"


def _service(request: Request) -> Service:
    return request.app.state.service


def _settings(request: Request) -> Settings:
    return request.app.state.settings


def _operator(
    operator: Annotated[
        str | None,
        Header(alias=OPERATOR, max_length=80, pattern=_NO_CONTROL, description="Who asks, for the record."),
    ] = None,
) -> str:
    return operator or "unknown"


ServiceOf = Annotated[Service, Depends(_service)]
SettingsOf = Annotated[Settings, Depends(_settings)]
Operator = Annotated[str, Depends(_operator)]
LeaseId = Annotated[
    str | None, Header(alias="Modallab-Lease", max_length=64, description="Id of the rig's lease.", pattern=_NO_CONTROL)
]

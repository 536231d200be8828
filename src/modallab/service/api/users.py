"""Users and their tokens; all of it for admins."""

from typing import Annotated

from fastapi import Body, Request, Response
from fastapi.openapi.models import Example

from modallab.core.documents.pages import Page
from modallab.core.documents.users import NewToken, TokenRequest, TokenView, UserChange, UserRequest, UserView
from modallab.service.api.access import role_needed
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import Operator, ServiceOf
from modallab.service.api.router import ONCE, PREFIX, make_router
from modallab.service.context import Service
from modallab.service.records.users import UserTable, ValidTokens

router = make_router("users")
ADMIN = role_needed("admin")
NewUser = Annotated[
    UserRequest, Body(openapi_examples={"operator": Example(value={"name": "Ada Lovelace", "role": "operator"})})
]
ChangedUser = Annotated[UserChange, Body(openapi_examples={"observer": Example(value={"role": "observer"})})]
TokenRequestBody = Annotated[
    TokenRequest, Body(openapi_examples={"for a script": Example(value={"label": "nightly script", "ttl_days": 90})})
]


@router.get("/users", openapi_extra=ADMIN)
def list_users(service: ServiceOf) -> Page[UserView]:
    """All users by name, including revoked ones."""
    return Page(items=tuple(_users(service).all_users()))


@router.post(
    "/users", status_code=201, dependencies=ONCE, responses=documented_responses(409, 507), openapi_extra=ADMIN
)
def add_user(new: NewUser, service: ServiceOf, operator: Operator, response: Response) -> UserView:
    """Add a user. Make a token for him at `/users/{user}/tokens`."""
    response.headers["Location"] = f"{PREFIX}/users"
    return _users(service).add(new, operator)


@router.get("/users/{user}", responses=documented_responses(404), openapi_extra=ADMIN)
def get_user(user: str, service: ServiceOf) -> UserView:
    """A user."""
    return _users(service).get(user)


@router.patch("/users/{user}", responses=documented_responses(404, 409, 507), openapi_extra=ADMIN)
def change_user(user: str, change: ChangedUser, service: ServiceOf, operator: Operator, request: Request) -> UserView:
    """Give a user another role; the rights of the user's tokens change with it."""
    changed = _users(service).change(user, change.role, operator)
    _refresh(request)
    return changed


@router.delete("/users/{user}", responses=documented_responses(404, 507), openapi_extra=ADMIN)
def revoke_user(user: str, service: ServiceOf, operator: Operator, request: Request) -> UserView:
    """Revoke all tokens of a user; the name stays in the audit record."""
    revoked = _users(service).revoke(user, operator)
    _refresh(request)
    return revoked


@router.get("/users/{user}/tokens", responses=documented_responses(404), openapi_extra=ADMIN)
def list_tokens(user: str, service: ServiceOf) -> Page[TokenView]:
    """The tokens of a user, the oldest first, including revoked and expired ones."""
    return Page(items=tuple(_users(service).tokens(user)))


@router.post(
    "/users/{user}/tokens", status_code=201, responses=documented_responses(404, 409, 507), openapi_extra=ADMIN
)
def make_token(
    user: str, new: TokenRequestBody, service: ServiceOf, operator: Operator, request: Request, response: Response
) -> NewToken:
    """Make a token. It is shown only once; a repeated request makes another one."""
    made = _users(service).make_token(user, new, operator)
    _refresh(request)
    response.headers["Cache-Control"] = "no-store"
    return made


@router.delete("/users/{user}/tokens/{token}", responses=documented_responses(404, 507), openapi_extra=ADMIN)
def revoke_token(user: str, token: str, service: ServiceOf, operator: Operator, request: Request) -> TokenView:
    """Revoke a token and its cookies."""
    revoked = _users(service).revoke_token(user, token, operator)
    _refresh(request)
    return revoked


def _users(service: Service) -> UserTable:
    return UserTable(service.engine)


def _refresh(request: Request) -> None:
    callers: ValidTokens = request.app.state.callers
    callers.refresh()

"""The part of the client that concerns users and their tokens."""

from collections.abc import Sequence
from urllib.parse import quote

from modallab.client.connection import Connection
from modallab.core.documents.pages import Page
from modallab.core.documents.users import (
    CallerView,
    LoginLink,
    Role,
    TokenMade,
    TokenNew,
    TokenView,
    UserChange,
    UserNew,
    UserView,
)


class UserCalls(Connection):
    """Who one is, and, for admins, who else may ask."""

    def me(self) -> CallerView:
        """Who you are to the service."""
        return self._get(CallerView, "/me")

    def login_link(self) -> LoginLink:
        """An address that logs a browser in as yourself, once."""
        return self._post(LoginLink, "/login-links")

    def users(self) -> tuple[UserView, ...]:
        """All users, revoked ones with them."""
        return self._get(Page[UserView], "/users").items

    def add_user(self, name: str, role: Role = "operator") -> UserView:
        """Add a user, who has no token yet."""
        return self._post(UserView, "/users", UserNew(name=name, role=role))

    def change_user(self, name: str, role: Role) -> UserView:
        """Give a user another role."""
        return UserView.model_validate_json(self._send("PATCH", _path_of_user(name), UserChange(role=role)).content)

    def revoke_user(self, name: str) -> UserView:
        """Have no token of a user count any more."""
        return self._delete(UserView, _path_of_user(name))

    def tokens(self, name: str) -> tuple[TokenView, ...]:
        """The tokens of a user."""
        return self._get(Page[TokenView], f"{_path_of_user(name)}/tokens").items

    def make_token(
        self,
        name: str,
        role: Role | None = None,
        rigs: Sequence[str] = (),
        ttl_days: float | None = None,
        label: str = "",
    ) -> TokenMade:
        """Make a token for a user; it is shown this once."""
        new = TokenNew(label=label, role=role, rigs=tuple(rigs), ttl_days=ttl_days)
        return self._post(TokenMade, f"{_path_of_user(name)}/tokens", new)

    def revoke_token(self, name: str, token: str) -> TokenView:
        """Have a token not count any more; `token` is its id."""
        return self._delete(TokenView, f"{_path_of_user(name)}/tokens/{token}")


def _path_of_user(name: str) -> str:
    return f"/users/{quote(name, safe='')}"

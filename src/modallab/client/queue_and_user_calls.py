"""The parts of the client that concern the queue of a rig, and users with their tokens."""

from collections.abc import Sequence
from urllib.parse import quote

from modallab.client.connection import Connection, RenewedLease
from modallab.core.documents.pages import Page
from modallab.core.documents.queue import (
    ConsentRequest,
    QueueItem,
    QueueItemRequest,
    QueueOrder,
    QueueReason,
    QueueView,
)
from modallab.core.documents.users import (
    CallerView,
    LoginLink,
    NewToken,
    Role,
    TokenRequest,
    TokenView,
    UserChange,
    UserRequest,
    UserView,
)
from modallab.core.plan import Plan


class QueueCalls(Connection):
    """Runs that wait for others."""

    def queue(self, rig: str, *, ended: bool = False) -> QueueView:
        """What goes on and what waits at a rig; with `ended` what has ended too."""
        return self._get(QueueView, f"/rigs/{rig}/queue", {"ended": "true"} if ended else {})

    def queue_run(self, rig: str, campaign: str, plan: Plan, note: str = "") -> QueueItem:
        """Queue a run behind the others; needs no lease."""
        return self._post(QueueItem, f"/rigs/{rig}/queue", QueueItemRequest(campaign=campaign, plan=plan, note=note))

    def reorder_queue(self, rig: str, items: Sequence[str]) -> QueueView:
        """Have all that waits run in this order."""
        return self._put(QueueView, f"/rigs/{rig}/queue/order", QueueOrder(items=tuple(items)))

    def skip_queued(self, rig: str, item: str, reason: str = "") -> QueueItem:
        """Take an item out that waits."""
        return self._post(QueueItem, f"/rigs/{rig}/queue/{item}/skip", QueueReason(reason=reason))

    def pause_queue(self, rig: str, reason: str = "") -> QueueView:
        """Have nothing begin; a run that is on goes on."""
        return self._post(QueueView, f"/rigs/{rig}/queue/pause", QueueReason(reason=reason))

    def resume_queue(self, rig: str, lease: RenewedLease) -> QueueView:
        """Let it go on."""
        return self._post(QueueView, f"/rigs/{rig}/queue/resume", None, lease)

    def give_consent(self, rig: str, lease: RenewedLease, *, drive: bool = False, at_bench: bool = False) -> QueueView:
        """Let what waits now begin by itself: with `drive` tests that move the output, with `at_bench` impact tests."""
        new = ConsentRequest(drive=drive, at_bench=at_bench)
        return self._put(QueueView, f"/rigs/{rig}/queue/consent", new, lease)

    def withdraw_consent(self, rig: str) -> QueueView:
        """Let nothing begin by itself."""
        return self._delete(QueueView, f"/rigs/{rig}/queue/consent")


class UserCalls(Connection):
    """Who one is, and, for admins, who else may ask."""

    def current_user(self) -> CallerView:
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
        return self._post(UserView, "/users", UserRequest(name=name, role=role))

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
    ) -> NewToken:
        """Make a token for a user; it is shown this once."""
        new = TokenRequest(label=label, role=role, rigs=tuple(rigs), ttl_days=ttl_days)
        return self._post(NewToken, f"{_path_of_user(name)}/tokens", new)

    def revoke_token(self, name: str, token: str) -> TokenView:
        """Have a token not count any more; `token` is its id."""
        return self._delete(TokenView, f"{_path_of_user(name)}/tokens/{token}")


def _path_of_user(name: str) -> str:
    return f"/users/{quote(name, safe='')}"

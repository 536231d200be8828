"""`modallab user`: who may ask the service, with which tokens; in the data folder, whether a service runs or not."""

import argparse
import getpass
from collections.abc import Iterable

from pydantic import ValidationError
from rich.console import Console

from modallab.cli.backup import require_data_folder
from modallab.core.documents.users import TokenRequest, UserRequest
from modallab.core.errors import DataError
from modallab.core.field_errors import error_sentences
from modallab.service.records.users import UserTable
from modallab.storage import Store


def run(arguments: argparse.Namespace) -> int:
    """Do what was chosen."""
    require_data_folder(arguments.data)
    with Store(arguments.data) as store:
        users = UserTable(store.catalogue.engine)
        try:
            {"add": _add, "token": _token, "list": _list, "revoke": _revoke}[arguments.action](users, arguments)
        except ValidationError as error:
            raise DataError(
                "; ".join(error_sentences(error)), where=f"user {arguments.action}", remedy="change the option"
            ) from error
    return 0


def _add(users: UserTable, arguments: argparse.Namespace) -> None:
    users.add(UserRequest(name=arguments.name, role=arguments.role), _operator_name())
    _token(users, arguments)


def _token(users: UserTable, arguments: argparse.Namespace) -> None:
    role = arguments.role if arguments.action == "token" else None
    rigs = tuple(arguments.rig or ())
    new = TokenRequest(label=arguments.label, role=role, rigs=rigs, ttl_days=arguments.days)
    made = users.make_token(arguments.name, new, _operator_name())
    until = f", until {made.about.expires_utc}" if made.about.expires_utc else ""
    _print([f"token {made.about.id} of {arguments.name}, {made.about.role}{until}; shown this once:", made.token])


def _list(users: UserTable, _: argparse.Namespace) -> None:
    for user in users.all_users():
        gone = f", revoked {user.revoked_utc}" if user.revoked_utc else ""
        _print([f"{user.name}: {user.role}{gone}"])
        for token in users.tokens(user.name):
            what = [token.role, *token.rigs, token.label]
            ends = [f"revoked {token.revoked_utc}"] if token.revoked_utc else []
            ends += [f"until {token.expires_utc}"] if token.expires_utc else []
            _print([f"  token {token.id}: {', '.join(part for part in (*what, *ends) if part)}"])


def _revoke(users: UserTable, arguments: argparse.Namespace) -> None:
    if arguments.token is None:
        users.revoke(arguments.name, _operator_name())
        _print([f"{arguments.name}: all tokens are revoked"])
    else:
        users.revoke_token(arguments.name, arguments.token, _operator_name())
        _print([f"token {arguments.token} of {arguments.name} is revoked"])


def _operator_name() -> str:
    return f"{getpass.getuser()} at the terminal"


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        Console().print(line, markup=False, highlight=False, soft_wrap=True)

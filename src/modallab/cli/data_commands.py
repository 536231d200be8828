"""The commands that move and keep data: export, backup, restore, retention; and users, who are kept with them."""

from pathlib import Path

from modallab.cli.options import Commands, not_negative, positive_number
from modallab.core.units import FRF_ESTIMATORS
from modallab.formats.format import writers

ROLES = ("observer", "operator", "admin")


def add_data_commands(commands: Commands) -> None:
    """Add them to the parser; nothing they need is imported."""
    _add_export(commands)
    _add_backup(commands)
    _add_restore(commands)
    _add_retention(commands)
    _add_user(commands)


def _add_export(commands: Commands) -> None:
    command = commands.add_parser("export", help="write a campaign in another format")
    command.add_argument("source", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="a campaign, or a data folder")
    command.add_argument("--format", required=True, choices=tuple(f.name for f in writers()), help="format to write")
    command.add_argument("--out", type=Path, required=True, metavar="FILE", help="file to write; for csv a folder")
    command.add_argument("--run", action="append", metavar="RUN", help="run of a data folder; may be repeated")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    command.add_argument(
        "--frf", nargs="?", const="H1", choices=FRF_ESTIMATORS, help="add the FRFs of the impact test (H1)"
    )
    command.add_argument(
        "--models", type=Path, metavar="MODELS.json", help="add the modes of this file of modallab identify"
    )
    command.set_defaults(module="export")


def _add_backup(commands: Commands) -> None:
    command = commands.add_parser("backup", help="copy a data folder, also while a run is being recorded")
    command.add_argument("data", type=Path, metavar="DATA", help="a data folder")
    command.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="a new or empty folder")
    command.set_defaults(module="backup", action="backup", out_is_folder=True)


def _add_restore(commands: Commands) -> None:
    command = commands.add_parser("restore", help="restore a data folder from a backup")
    command.add_argument("backup", type=Path, metavar="BACKUP", help="folder that modallab backup wrote")
    command.add_argument("--out", type=Path, required=True, metavar="DATA", help="a new or empty folder")
    command.add_argument("--database", metavar="URL", help="empty PostgreSQL database for the catalogue")
    command.set_defaults(module="backup", action="restore", out_is_folder=True)


def _add_retention(commands: Commands) -> None:
    command = commands.add_parser("retention", help="list samples that may be deleted, and delete them with --delete")
    command.add_argument("data", type=Path, metavar="DATA", help="a data folder")
    command.add_argument(
        "--older-than", type=not_negative, default=0.0, metavar="DAYS", help="smallest age since the end of the run"
    )
    command.add_argument("--state", action="append", choices=("done", "failed", "aborted"), help="may be repeated")
    command.add_argument("--valid", action="store_true", help="also runs with valid data")
    command.add_argument(
        "--delete", action="store_true", help="delete the samples; without this option they are only listed"
    )
    command.set_defaults(module="backup", action="retention")


def _add_user(commands: Commands) -> None:
    user = commands.add_parser("user", help="manage users of the service and their tokens")
    actions = user.add_subparsers(metavar="ACTION", required=True, dest="action")
    add = actions.add_parser("add", help="add a user, and make a token")
    add.add_argument("--role", choices=ROLES, default="operator", help="role of the user")
    token = actions.add_parser("token", help="make another token for a user")
    token.add_argument("--role", choices=ROLES, help="role of the token, if lower than the user's")
    for command in (add, token):
        command.add_argument("--rig", action="append", metavar="ID", help="valid for this rig only; may be repeated")
        command.add_argument(
            "--days", type=positive_number, metavar="N", help="days of validity (default: until revoked)"
        )
        command.add_argument("--label", default="", help="program or device that uses the token")
    listed = actions.add_parser("list", help="list users and tokens, without the secrets")
    revoke = actions.add_parser("revoke", help="revoke the tokens of a user")
    revoke.add_argument("--token", metavar="ID", help="token to revoke (default: all)")
    for command in (add, token, revoke):
        command.add_argument("name", metavar="NAME", help="name of the user")
    for command in (add, token, listed, revoke):
        command.add_argument(
            "--data", type=Path, default=Path("data"), metavar="FOLDER", help="data folder of the service"
        )
    user.set_defaults(module="user")

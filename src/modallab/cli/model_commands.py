"""The command `model` and its options, without importing what it does."""

from pathlib import Path
from typing import Any

from modallab.cli.model_predictions import MOTIONS, PREDICTED
from modallab.cli.options import JSON_HELP, Commands, add_saying, positive_integer, positive_number
from modallab.core.units import TESTS


def add_model_commands(commands: Commands) -> None:
    """Add it to the parser."""
    model = commands.add_parser(
        "model", help="put a modal model to use: what makes a response, and what a change makes of it"
    )
    actions = model.add_subparsers(metavar="ACTION", required=True, dest="action")
    for add in (_participation, _nodes, _shape, _frf, *PREDICTED, _compare, _update):
        command = add(actions)
        command.add_argument(
            "model", type=Path, metavar="MODELS.json|FOLDER|CAMPAIGN.h5", help="models, or a campaign to identify"
        )
        command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside it")
        command.add_argument("--test", choices=TESTS, help="whose model (default: the first)")
        command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP.format("answer"))
        add_saying(command)
    model.set_defaults(module="model")


def _participation(actions: Commands) -> Any:
    command = actions.add_parser("participation", help="which modes make the response at a point")
    command.add_argument("--at", type=int, required=True, metavar="POINT", help="of the force")
    command.add_argument("--of", type=int, required=True, metavar="POINT", help="of the motion")
    span = command.add_mutually_exclusive_group()
    span.add_argument(
        "--band", nargs=2, type=positive_number, metavar=("LO", "HI"), help="in Hz (default: the model's)"
    )
    span.add_argument("--after", nargs=2, type=float, metavar=("BEGIN", "END"), help="a time in s after a hit")
    command.add_argument("--quantity", choices=MOTIONS, default="velocity", help="of the motion")
    return command


def _nodes(actions: Commands) -> Any:
    return actions.add_parser("nodes", help="antinodes and nodes of each mode: where to hit, where to mount")


def _shape(actions: Commands) -> Any:
    command = actions.add_parser("shape", help="the shape of a mode, or the deflection shape that was measured")
    which = command.add_mutually_exclusive_group(required=True)
    which.add_argument("--mode", type=int, metavar="N", help="from 1")
    which.add_argument("--hz", type=positive_number, help="frequency of an operating deflection shape")
    command.add_argument("--at", type=int, metavar="POINT", help="of the force, with --hz")
    command.add_argument("--out", type=Path, metavar="FILE.gif", help="a picture that moves")
    return command


def _compare(actions: Commands) -> Any:
    command = actions.add_parser("compare", help="pairs of modes with another model: MAC, frequencies, damping, COMAC")
    command.add_argument(
        "--other", type=Path, required=True, metavar="FILE", help="models, finite elements, a campaign"
    )
    command.add_argument("--out", type=Path, metavar="FILE.svg|.png", help="a picture of both shapes of each pair")
    return command


def _update(actions: Commands) -> Any:
    command = actions.add_parser("update", help="estimate the parameters of a finite-element model, or of the beam")
    command.add_argument(
        "--fe",
        type=Path,
        metavar="FILE",
        help="matrices, or a Python file with predict(numbers) and priors (default: the rig's beam)",
    )
    command.add_argument(
        "--prior",
        nargs=3,
        action="append",
        metavar=("NAME", "VALUE", "SIGMA"),
        help="of a parameter such as spring@8; 5%% is a deviation relative to the value",
    )
    command.add_argument("--hold-out", nargs="+", type=positive_integer, metavar="MODE", help="modes that only check")
    return command


def _frf(actions: Commands) -> Any:
    command = actions.add_parser("frf", help="FRFs between points, measured pairs or not, for other programs")
    command.add_argument("--outputs", type=int, nargs="+", metavar="POINT", help="(default: all that have a sensor)")
    command.add_argument("--inputs", type=int, nargs="+", metavar="POINT", help="(default: those that were driven)")
    command.add_argument(
        "--quantity", choices=("receptance", "mobility", "inertance"), default="mobility", help="what is written"
    )
    command.add_argument(
        "--lines", type=int, default=1000, metavar="N", help="evenly over the band, beside those about each mode"
    )
    command.add_argument("--modes-alone", action="store_true", help="without what lies outside the band")
    command.add_argument("--out", type=Path, required=True, metavar="FILE", help=".uff, .mat or .h5")
    return command

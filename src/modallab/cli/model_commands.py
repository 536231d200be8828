"""The command `model` and its options, without importing what it does."""

from pathlib import Path
from typing import Any

from modallab.cli.options import JSON_HELP, Commands, add_verbosity_option, positive_integer, positive_number
from modallab.core.units import TESTS

_MOTIONS = ("displacement", "velocity", "acceleration")


def add_model_commands(commands: Commands) -> None:
    """Add it to the parser."""
    model = commands.add_parser("model", help="use a modal model: contributions to a response, and effects of a change")
    actions = model.add_subparsers(metavar="ACTION", required=True, dest="action")
    for add in (_participation, _nodes, _shape, _frf, _reduction, *_PREDICTED, _compare, _update):
        command = add(actions)
        command.add_argument(
            "model", type=Path, metavar="MODELS.json|FOLDER|CAMPAIGN.h5", help="models, or a campaign to identify"
        )
        command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the models")
        command.add_argument("--test", choices=TESTS, help="test of the model (default: the first)")
        command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP.format("answer"))
        add_verbosity_option(command)
    model.set_defaults(module="model")


def _participation(actions: Commands) -> Any:
    command = actions.add_parser("participation", help="share of each mode in the response at a point")
    command.add_argument("--at", type=int, required=True, metavar="POINT", help="point of the force")
    command.add_argument("--of", type=int, required=True, metavar="POINT", help="point of the motion")
    span = command.add_mutually_exclusive_group()
    span.add_argument(
        "--band", nargs=2, type=positive_number, metavar=("LO", "HI"), help="band in Hz (default: that of the model)"
    )
    span.add_argument("--after", nargs=2, type=float, metavar=("BEGIN", "END"), help="time range after a hit, s")
    command.add_argument("--quantity", choices=_MOTIONS, default="velocity", help="quantity of the motion")
    return command


def _nodes(actions: Commands) -> Any:
    return actions.add_parser("nodes", help="antinodes and nodes of each mode: where to hit, where to mount")


def _shape(actions: Commands) -> Any:
    command = actions.add_parser("shape", help="the shape of a mode, or the measured deflection shape")
    which = command.add_mutually_exclusive_group(required=True)
    which.add_argument("--mode", type=int, metavar="N", help="number of the mode, from 1")
    which.add_argument("--hz", type=positive_number, help="frequency of an operating deflection shape")
    command.add_argument("--at", type=int, metavar="POINT", help="point of the force, with --hz")
    command.add_argument("--out", type=Path, metavar="FILE.gif", help="file of a moving picture")
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
        help="prior of a parameter such as spring@8; 5%% is a deviation relative to the value",
    )
    command.add_argument(
        "--hold-out", nargs="+", type=positive_integer, metavar="MODE", help="modes held out as a check"
    )
    return command


def _frf(actions: Commands) -> Any:
    command = actions.add_parser("frf", help="FRFs between points, measured pairs or not, for other programs")
    command.add_argument("--outputs", type=int, nargs="+", metavar="POINT", help="(default: all that have a sensor)")
    command.add_argument("--inputs", type=int, nargs="+", metavar="POINT", help="(default: those that were driven)")
    command.add_argument(
        "--quantity", choices=("receptance", "mobility", "inertance"), default="mobility", help="kind of FRF"
    )
    command.add_argument(
        "--lines",
        type=int,
        default=1000,
        metavar="N",
        help="number of frequencies spread evenly over the band, besides those about each mode",
    )
    command.add_argument("--modes-alone", action="store_true", help="without residual terms")
    command.add_argument("--out", type=Path, required=True, metavar="FILE", help=".uff, .mat or .h5")
    return command


def _reduction(actions: Commands) -> Any:
    return actions.add_parser("reduction", help="size of the FRFs and of the model, and the error of each pair")


def _response(actions: Commands) -> Any:
    command = actions.add_parser("response", help="the response to forces: peak, rms, octave bands, a file")
    command.add_argument(
        "--at", type=int, nargs="+", required=True, metavar="POINT", help="point of the force, or of each force"
    )
    command.add_argument(
        "--of", type=int, nargs="+", metavar="POINT", help="points of the motion (default: all with a sensor)"
    )
    force = command.add_mutually_exclusive_group(required=True)
    force.add_argument("--force", type=Path, metavar="FILE", help="samples in N, a column for each force; .csv or .npy")
    force.add_argument("--impulse", type=float, metavar="NS", help="an impulse of this size in one sample")
    force.add_argument("--sine", type=float, nargs=2, metavar=("HZ", "N"), help="a sine from the first sample on")
    force.add_argument(
        "--sweep", type=float, nargs=3, metavar=("HZ", "HZ", "N"), help="a sweep from, to, with this amplitude"
    )
    force.add_argument(
        "--random", type=Path, metavar="FILE", help="a random force of this spectrum: rows of Hz and N^2/Hz"
    )
    command.add_argument("--step", type=positive_number, required=True, metavar="S", help="time between samples")
    command.add_argument("--seconds", type=positive_number, help="duration of a force that is not from a file")
    command.add_argument("--seed", type=int, default=0, metavar="N", help="seed of --random (default: 0)")
    command.add_argument("--quantity", choices=_MOTIONS, default="acceleration", help="quantity of the motion")
    kinds = ("band-limited", "linear")
    command.add_argument("--between", choices=kinds, default=kinds[0], help="course of a force between its samples")
    _add_start(command)
    command.add_argument("--out", type=Path, metavar="FILE", help=".csv or .mat with motion and deviation over time")
    return command


def _add_start(command: Any) -> None:
    for name, unit, called in (("displaced", "M", "displacement"), ("moving", "M/S", "velocity")):
        about = f"{called} of a point at the first sample"
        command.add_argument(f"--{name}", type=float, nargs=2, action="append", metavar=("POINT", unit), help=about)


def _state_space(actions: Commands) -> Any:
    command = actions.add_parser("state-space", help="matrices A, B, C, D of the modes, for simulators and control")
    command.add_argument("--at", type=int, nargs="+", required=True, metavar="POINT", help="points of the forces")
    command.add_argument(
        "--of", type=int, nargs="+", metavar="POINT", help="points of the motion (default: all with a sensor)"
    )
    command.add_argument("--quantity", choices=_MOTIONS, default="acceleration", help="quantity of the motion")
    command.add_argument(
        "--out", type=Path, required=True, metavar="FILE.mat", help="file of the matrices, with names and units"
    )
    return command


def _modify(actions: Commands) -> Any:
    command = actions.add_parser("modify", help="the modes with masses, springs, dampers, absorbers or links added")
    command.add_argument(
        "--at",
        type=int,
        nargs="+",
        default=[],
        metavar="POINT",
        help="points of --mass, --spring and --damper, each at all",
    )
    command.add_argument("--to", type=int, metavar="POINT", help="other end of spring and damper (default: ground)")
    for name, unit, said in (
        ("mass", "KG", "below 0: removed; several: one for each point"),
        ("spring", "N/M", "stiffness"),
        ("damper", "NS/M", "viscous damping"),
    ):
        command.add_argument(f"--{name}", type=float, nargs="+", default=[], metavar=unit, help=said)
    command.add_argument(
        "--absorber",
        nargs=4,
        type=float,
        action="append",
        default=[],
        metavar=("POINT", "KG", "HZ", "PERCENT"),
        help="its point, mass, natural frequency, damping ratio; repeat for several",
    )
    command.add_argument("--ground", type=int, nargs="+", default=[], metavar="POINT", help="points fixed to ground")
    _add_check(command)
    command.add_argument(
        "--link", type=int, nargs=2, action="append", default=[], metavar="POINT", help="two points linked rigidly"
    )
    return command


def _tune(actions: Commands) -> Any:
    command = actions.add_parser("tune", help="the mass or spring that moves a mode to a frequency, at each point")
    command.add_argument("--mode", type=int, required=True, metavar="N", help="number of the mode, from 1")
    command.add_argument("--to", type=positive_number, required=True, metavar="HZ", help="the frequency")
    _add_by_and_at(command)
    return command


def _add_check(command: Any) -> None:
    command.add_argument("--check", type=Path, metavar="FILE", help="models or campaign measured with the changes")


def _couple(actions: Commands) -> Any:
    command = actions.add_parser("couple", help="the modes with another structure coupled, or removed")
    command.add_argument(
        "--other", type=Path, required=True, metavar="FILE", help="models of the other structure, or a campaign"
    )
    command.add_argument(
        "--pair",
        type=int,
        nargs=2,
        action="append",
        required=True,
        metavar=("POINT", "OTHER"),
        help="pair of points to couple; repeat for several",
    )
    command.add_argument(
        "--joint", type=positive_number, metavar="N/M", help="stiffness of each joint (default: rigid)"
    )
    command.add_argument("--remove", action="store_true", help="remove the other structure from a measurement of both")
    _add_check(command)
    return command


def _free(actions: Commands) -> Any:
    command = actions.add_parser("free", help="the mass or spring that leaves no mode in a band, at each point")
    command.add_argument("--band", nargs=2, type=positive_number, required=True, metavar=("LO", "HI"), help="in Hz")
    _add_by_and_at(command)
    return command


def _absorber(actions: Commands) -> Any:
    command = actions.add_parser("absorber", help="the absorber that makes the peak of a mode smallest")
    command.add_argument("--mode", type=int, required=True, metavar="N", help="number of the mode, from 1")
    command.add_argument("--at", type=int, required=True, metavar="POINT", help="point of the absorber")
    command.add_argument("--mass", type=positive_number, required=True, metavar="KG", help="mass of the absorber")
    return command


def _add_by_and_at(command: Any) -> None:
    command.add_argument("--by", choices=("mass", "spring"), required=True, help="kind of change")
    command.add_argument("--at", type=int, nargs="+", metavar="POINT", help="points to try (default: all)")


_PREDICTED = (_response, _state_space, _modify, _couple, _tune, _free, _absorber)
"""Each adds its command."""

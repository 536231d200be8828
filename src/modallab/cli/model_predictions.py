"""The options of `model` that predict: a response, a change, what a wanted property needs."""

from pathlib import Path
from typing import Any

from modallab.cli.options import Commands, positive_number

MOTIONS = ("displacement", "velocity", "acceleration")


def _response(actions: Commands) -> Any:
    command = actions.add_parser("response", help="the motion that forces give: peak, rms, octave bands, a file")
    command.add_argument("--at", type=int, nargs="+", required=True, metavar="POINT", help="of the force, or of each")
    command.add_argument("--of", type=int, nargs="+", metavar="POINT", help="that move (default: all with a sensor)")
    force = command.add_mutually_exclusive_group(required=True)
    force.add_argument("--force", type=Path, metavar="FILE", help="samples in N, a column for each force; .csv or .npy")
    force.add_argument("--impulse", type=float, metavar="NS", help="all of the force within one sample")
    force.add_argument("--sine", type=float, nargs=2, metavar=("HZ", "N"), help="from the first sample on")
    force.add_argument("--sweep", type=float, nargs=3, metavar=("HZ", "HZ", "N"), help="from, to, amplitude")
    force.add_argument("--random", type=Path, metavar="FILE", help="its spectrum: rows of Hz and N^2/Hz")
    command.add_argument("--step", type=positive_number, required=True, metavar="S", help="between samples")
    command.add_argument("--seconds", type=positive_number, help="how long a force lasts that is no file")
    command.add_argument("--seed", type=int, default=0, metavar="N", help="of --random (default: 0)")
    command.add_argument("--quantity", choices=MOTIONS, default="acceleration", help="of the motion")
    kinds = ("band-limited", "linear")
    command.add_argument("--between", choices=kinds, default=kinds[0], help="what a force is between its samples")
    _add_start(command)
    command.add_argument("--out", type=Path, metavar="FILE", help=".csv or .mat with motion and deviation over time")
    return command


def _add_start(command: Any) -> None:
    for name, unit in (("displaced", "M"), ("moving", "M/S")):
        command.add_argument(
            f"--{name}", type=float, nargs=2, action="append", metavar=("POINT", unit), help="at the first sample"
        )


def _state_space(actions: Commands) -> Any:
    command = actions.add_parser("state-space", help="matrices A, B, C, D of the modes, for simulators and control")
    command.add_argument("--at", type=int, nargs="+", required=True, metavar="POINT", help="of the forces")
    command.add_argument("--of", type=int, nargs="+", metavar="POINT", help="that move (default: all with a sensor)")
    command.add_argument("--quantity", choices=MOTIONS, default="acceleration", help="of the motion")
    command.add_argument("--out", type=Path, required=True, metavar="FILE.mat", help="with names and units")
    return command


def _modify(actions: Commands) -> Any:
    command = actions.add_parser("modify", help="the modes with masses, springs, dampers, absorbers or links added")
    command.add_argument(
        "--at", type=int, nargs="+", default=[], metavar="POINT", help="of --mass, --spring and --damper, each at all"
    )
    command.add_argument("--to", type=int, metavar="POINT", help="other end of spring and damper (default: ground)")
    for name, unit, said in (
        ("mass", "KG", "below 0: taken away; several: one for each point"),
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
        help="its mass, natural frequency, damping ratio; repeat it for several",
    )
    command.add_argument(
        "--ground", type=int, nargs="+", default=[], metavar="POINT", help="points that no longer move"
    )
    _add_check(command)
    command.add_argument(
        "--link", type=int, nargs=2, action="append", default=[], metavar="POINT", help="two points that move as one"
    )
    return command


def _tune(actions: Commands) -> Any:
    command = actions.add_parser("tune", help="the mass or spring that brings a mode to a frequency, at each point")
    command.add_argument("--mode", type=int, required=True, metavar="N", help="from 1")
    command.add_argument("--to", type=positive_number, required=True, metavar="HZ", help="the frequency")
    _add_by_and_at(command)
    return command


def _add_check(command: Any) -> None:
    command.add_argument("--check", type=Path, metavar="FILE", help="models or campaign measured with the changes")


def _couple(actions: Commands) -> Any:
    command = actions.add_parser("couple", help="the modes with another structure held to it, or taken away")
    command.add_argument("--other", type=Path, required=True, metavar="FILE", help="its models, or a campaign")
    command.add_argument(
        "--pair",
        type=int,
        nargs=2,
        action="append",
        required=True,
        metavar=("POINT", "OTHER"),
        help="points held together; repeat it for several",
    )
    command.add_argument(
        "--joint", type=positive_number, metavar="N/M", help="stiffness of each joint (default: rigid)"
    )
    command.add_argument("--remove", action="store_true", help="take it away from a measurement of both")
    _add_check(command)
    return command


def _free(actions: Commands) -> Any:
    command = actions.add_parser("free", help="the mass or spring that leaves no mode in a band, at each point")
    command.add_argument("--band", nargs=2, type=positive_number, required=True, metavar=("LO", "HI"), help="in Hz")
    _add_by_and_at(command)
    return command


def _absorber(actions: Commands) -> Any:
    command = actions.add_parser("absorber", help="the absorber that leaves the least peak about a mode")
    command.add_argument("--mode", type=int, required=True, metavar="N", help="from 1")
    command.add_argument("--at", type=int, required=True, metavar="POINT", help="where it hangs")
    command.add_argument("--mass", type=positive_number, required=True, metavar="KG", help="of it")
    return command


def _add_by_and_at(command: Any) -> None:
    command.add_argument("--by", choices=("mass", "spring"), required=True, help="what is added")
    command.add_argument("--at", type=int, nargs="+", metavar="POINT", help="points to try (default: all)")


PREDICTED = (_response, _state_space, _modify, _couple, _tune, _free, _absorber)
"""Each adds its command."""

"""Every command and its options, in one place, without importing what they do."""

import argparse
from pathlib import Path
from typing import Any

from modallab.cli.data_commands import add_data_commands
from modallab.cli.gap_commands import add_gap_commands
from modallab.cli.model_commands import add_model_commands
from modallab.cli.options import (
    JSON_HELP,
    Commands,
    Parser,
    add_verbosity_option,
    not_negative,
    positive_integer,
    positive_number,
)
from modallab.core.units import FRF_ESTIMATORS, TESTS
from modallab.formats.asked import ASKED, ImportOption, Kind
from modallab.formats.format import readers
from modallab.identification.estimator import USUAL, estimator_names

_KINDS: dict[Kind, Any] = {"text": str, "number": positive_number, "count": positive_integer, "map": Path}


def build_parser(version: str) -> argparse.ArgumentParser:
    """The parser; each command names the module of `modallab.cli` that runs it."""
    parser = Parser(
        prog="modallab",
        description="Run modal tests on a cantilever, identify the modal model, diagnose the gap to its simulation.",
    )
    parser.add_argument("--version", action="version", version=f"modallab {version}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_demo(commands)
    _add_import(commands)
    _add_identify(commands)
    add_model_commands(commands)
    add_gap_commands(commands)
    _add_rig(commands)
    _add_devices(commands)
    _add_campaign(commands)
    _add_serve(commands)
    add_data_commands(commands)
    return parser


def _add_demo(commands: Commands) -> None:
    demo = commands.add_parser("demo", help="run a whole modal test on the simulated bench")
    demo.add_argument("--out", type=Path, default=Path("demo"), metavar="FOLDER", help="folder for the results")
    demo.add_argument("--seed", type=int, default=1, help="seed of the simulated bench")
    demo.add_argument(
        "--effect",
        action="append",
        metavar="NAME,NUMBER=VALUE,...",
        help="an effect of that bench, such as added_mass,mass=0.05,x=0.8; may be repeated",
    )
    demo.add_argument(
        "--clean", action="store_true", help="use an ideal bench (default: a bench with the usual tolerances)"
    )
    demo.add_argument(
        "--serve", action="store_true", help="serve the same bench on the operator's page, to test it by hand"
    )
    add_verbosity_option(demo)
    demo.set_defaults(module="demo", out_is_folder=True)


def _add_import(commands: Commands) -> None:
    command = commands.add_parser("import", help="convert recordings of other programs into one campaign file")
    command.add_argument("sources", type=Path, nargs="+", metavar="SOURCE", help=", ".join(f.title for f in readers()))
    command.add_argument(
        "--rig",
        type=Path,
        metavar="RIG.yaml",
        help="rig file with the channels; without it a draft is written from the recording",
    )
    command.add_argument("--out", type=Path, required=True, metavar="CAMPAIGN.h5", help="the campaign file")
    for name, one in ASKED.items():
        _add_asked(command, name, one)
    add_verbosity_option(command)
    command.set_defaults(module="import_")


def _add_asked(command: Any, name: str, one: ImportOption) -> None:
    said: dict[str, Any] = {"help": one.about, "dest": one.called or name}
    if one.kind == "switch":
        said["action"] = "store_true"
    else:
        said |= {"choices": TESTS} if one.kind == "test" else {"type": _KINDS[one.kind], "metavar": one.metavar}
    if one.several or one.each:
        said["nargs"] = "+"
    command.add_argument(f"--{(one.called or name).replace('_', '-')}", **said)


def _add_identify(commands: Commands) -> None:
    command = commands.add_parser("identify", help="identify the modal model of a campaign")
    command.add_argument(
        "campaign",
        type=Path,
        nargs="+",
        metavar="FOLDER|CAMPAIGN.h5",
        help="campaign; several campaigns: the set-ups of one test",
    )
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    _add_estimation(command)
    command.add_argument(
        "--pick",
        type=positive_number,
        nargs="+",
        metavar="HZ",
        help="frequencies in Hz of the modes to keep, within 2 %%",
    )
    command.add_argument(
        "--drop",
        type=positive_number,
        nargs="+",
        metavar="HZ",
        help="frequencies in Hz of the modes to leave out, within 2 %%",
    )
    command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP.format("models"))
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML report")
    add_verbosity_option(command)
    command.set_defaults(module="identify")


def _add_estimation(command: argparse.ArgumentParser) -> None:
    command.add_argument("--method", choices=estimator_names(), default=USUAL, help="estimator")
    command.add_argument(
        "--refine",
        action=argparse.BooleanOptionalAction,
        help="refine the poles by maximum likelihood, or not (default: that of the method)",
    )
    command.add_argument(
        "--frf",
        choices=FRF_ESTIMATORS,
        default="H1",
        help="FRF estimator: H2 and Hv allow for noise on the force (random drives, chirps, several hits a point)",
    )
    command.add_argument("--test", choices=TESTS, help="test to identify (default: every test of the campaign)")
    command.add_argument("--band", type=not_negative, nargs=2, metavar=("LO", "HI"), help="band in Hz")
    command.add_argument(
        "--order", type=int, metavar="N", help="highest model order of the estimator (default: chosen from the data)"
    )
    command.add_argument(
        "--response-only",
        nargs="?",
        const="ssi_cov",
        choices=("ssi_cov", "plscf_spectra"),
        help="identify from the responses alone to a random force (default: only if no force was measured)",
    )


def _add_rig(commands: Commands) -> None:
    rig = commands.add_parser("rig", help="check the channels of a bench, and calibrate them")
    actions = rig.add_subparsers(metavar="ACTION", required=True, dest="action")
    check = actions.add_parser("check", help="check every channel and report faults")
    _add_rig_check(check)
    calibrate = actions.add_parser("calibrate", help="measure a channel's sensitivity for the rig's history")
    _add_calibration(calibrate)
    mass = actions.add_parser(
        "mass", help="check force transducer and accelerometer on a free rigid mass, before or after a test"
    )
    _add_rigid_mass(mass)
    for command in (check, calibrate, mass):
        command.add_argument("rig", type=Path, metavar="RIG.yaml", help="the rig file")
        command.add_argument("--bench", metavar="ADDRESS", help="address of the bench (default: that of the rig file)")
        command.add_argument("--seconds", type=positive_number, default=3.0, help="length of the record in s")
    reset = actions.add_parser("reset", help="reset a tripped rig, after a check of the bench")
    reset.add_argument("rig", type=Path, metavar="RIG.yaml", help="the rig file")
    reset.add_argument("--bench", metavar="ADDRESS", help="address of the bench (default: that of the rig file)")
    reset.add_argument("--data", type=Path, required=True, metavar="FOLDER", help="data folder of the recordings")
    rig.set_defaults(module="rig")


def _add_rig_check(check: argparse.ArgumentParser) -> None:
    check.add_argument("--tap", action="store_true", help="check the polarity too, by a tap at every sensor's point")
    check.add_argument(
        "--drive", type=float, metavar="V", help="check the generator's clock too, by a burst of this amplitude"
    )
    check.add_argument(
        "--common",
        nargs=2,
        metavar="NAME",
        help="measure the phase at 10 kHz between two channels of different devices that read one signal, as "
        "through a tee",
    )


def _add_calibration(calibrate: argparse.ArgumentParser) -> None:
    calibrate.add_argument("--channel", required=True, metavar="NAME", help="the channel")
    calibrate.add_argument(
        "--method",
        required=True,
        choices=("turnover", "shunt", "reference", "rigid-mass"),
        help="method of the calibration",
    )
    calibrate.add_argument(
        "--value", type=float, help="value of the shunt (SI), rms of the reference (SI), or mass in kg"
    )
    calibrate.add_argument(
        "--frequency", type=positive_number, default=159.15, metavar="HZ", help="frequency of the reference shaker"
    )
    calibrate.add_argument("--against", metavar="NAME", help="accelerometer on the free mass (default: the first)")
    calibrate.add_argument("--remark", default="", metavar="TEXT", help="remark for the history")
    calibrate.add_argument("--yes", action="store_true", help="do not wait for Enter")
    calibrate.set_defaults(in_place=True)
    calibrate.add_argument("--out", type=Path, metavar="RIG.yaml", help="file of the new rig (default: in place)")


def _add_rigid_mass(mass: argparse.ArgumentParser) -> None:
    mass.add_argument(
        "--mass", type=positive_number, required=True, metavar="KG", help="mass including the accelerometer"
    )
    mass.add_argument("--when", required=True, choices=("before", "after"), help="before or after the test")
    mass.add_argument("--against", metavar="NAME", help="accelerometer on the free mass (default: the first)")
    mass.add_argument("--into", type=Path, required=True, metavar="FOLDER", help="data folder of the campaign")
    mass.add_argument("--yes", action="store_true", help="do not wait for Enter")


def _add_devices(commands: Commands) -> None:
    command = commands.add_parser("devices", help="list the devices, each with its address")
    command.add_argument(
        "address",
        nargs="?",
        default="",
        help="list only the devices at this address, such as nidaqmx+grpc://host:31763",
    )
    command.add_argument("--release", action="store_true", help="release devices that a killed program left reserved")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, needed for --release")
    command.set_defaults(module="devices")


def _add_serve(commands: Commands) -> None:
    command = commands.add_parser("serve", help="run the REST service, the operator's page and the emergency stop")
    command.add_argument("--rig", type=Path, action="append", metavar="RIG.yaml", help="may be repeated")
    command.add_argument("--bench", metavar="ADDRESS", help="address of the bench (default: that of the rig file)")
    command.add_argument("--data", type=Path, metavar="FOLDER", help="data folder for the recordings (default: data)")
    command.add_argument(
        "--host", metavar="ADDRESS", help="address to listen on; any other needs a chosen token (default: 127.0.0.1)"
    )
    command.add_argument("--port", type=int, metavar="N", help="port of the REST service (default: 8000)")
    command.add_argument("--stop-port", type=int, metavar="N", help="port of the emergency stop (default: 8001)")
    command.add_argument("--token-file", type=Path, metavar="FILE", help="file of the token")
    command.add_argument("--tls-cert", type=Path, metavar="FILE", help="use TLS with this certificate, as PEM")
    command.add_argument("--tls-key", type=Path, metavar="FILE", help="key of the certificate")
    command.add_argument(
        "--tls-self-signed", action="store_const", const=True, help="make a certificate in the data folder, and use it"
    )
    command.add_argument("--scheduler", metavar="ADDRESS", help="address of a Dask scheduler (default: own workers)")
    command.add_argument(
        "--workers", type=int, metavar="N", help="number of processes that compute jobs on this machine"
    )
    command.add_argument("--open", action="store_true", help="open a browser that is logged in")
    command.add_argument("--no-jobs", dest="jobs", action="store_const", const=False, help="do not compute jobs")
    command.set_defaults(module="serve")


def _add_campaign(commands: Commands) -> None:
    campaign = commands.add_parser("campaign", help="run tests on a bench")
    actions = campaign.add_subparsers(metavar="ACTION", required=True, dest="action")
    command = actions.add_parser("run", help="run the tests of a plan, identify, and show the model")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml", help="the rig file")
    command.add_argument("--plan", type=Path, required=True, metavar="PLAN.yaml", help="one test, or a list of them")
    command.add_argument("--bench", metavar="ADDRESS", help="address of the bench (default: that of the rig file)")
    command.add_argument(
        "--data", type=Path, default=Path("data"), metavar="FOLDER", help="data folder for the recordings"
    )
    command.add_argument("--name", help="name of the campaign (default: that of the rig)")
    command.add_argument("--operator", metavar="NAME", help="name of the operator (default: the user logged in)")
    command.add_argument("--out", type=Path, metavar="CAMPAIGN.h5", help="write the recordings as one file")
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML report")
    command.add_argument("--mute", action="store_true", help="turn the tones off")
    command.add_argument(
        "--keys",
        default="",
        metavar="MAP",
        help="keys of accept, undo, pause and quit, for a pedal such as undo=b,accept=pagedown",
    )
    campaign.set_defaults(module="campaign")

"""The commands below `modallab gap`, without importing what they do."""

from pathlib import Path

from modallab.cli.options import (
    JSON_HELP,
    Commands,
    add_verbosity_option,
    not_negative,
    positive_integer,
    positive_number,
)


def add_gap_commands(commands: Commands) -> None:
    """Add them; each names the module of `modallab.cli` that runs it."""
    gap = commands.add_parser(
        "gap", help="diagnose where and why simulation and bench differ, and how far the gap closes"
    )
    actions = gap.add_subparsers(metavar="ACTION", required=True, dest="action")
    gap.set_defaults(module="gap")
    _add_diagnose(actions)
    _add_predict(actions)
    command = actions.add_parser("distinguishability", help="predict which effects a plan cannot distinguish")
    command.add_argument("rig", type=Path, metavar="RIG.yaml", help="rig file, whose tolerances count")
    command.add_argument("plan", type=Path, metavar="PLAN.yaml", help="one test, or a list of them")
    command = actions.add_parser("effects", help="list the effects of the catalogue: possible causes of a gap")
    command.add_argument("names", nargs="*", metavar="EFFECT", help="effects to describe (default: one line for each)")
    command.set_defaults(module="effects")
    _add_revisions(actions)
    _add_export(actions)
    _add_next(actions)
    _add_blind(actions)
    command = actions.add_parser("paper", help="explain each number of the paper's Table 1")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the result as JSON")
    command.set_defaults(module="gap_paper")


def _add_diagnose(actions: Commands) -> None:
    command = actions.add_parser("diagnose", help="diagnose a campaign")
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="a campaign, or its folder")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    command.add_argument(
        "--hold-out",
        default="mixed",
        metavar="RULE",
        help="records held out from the fit: mixed (one drive point of several, every third sine frequency), spread "
        "(every third hit at each point), point:N, level:NAME, test:impact, test:sine or last:SHARE",
    )
    command.add_argument(
        "--simulation",
        type=Path,
        metavar="PRED.h5",
        help="compare the bench with the simulation that predicted these records",
    )
    command.add_argument(
        "--diagnosis", type=Path, metavar="D.json", help="diagnosis of the bench, with --simulation, if known"
    )
    command.add_argument(
        "--reference",
        type=Path,
        metavar="MODELS.json|CAMPAIGN|MODEL",
        help="reference for any structure, instead of the simulation: an earlier campaign, its modal model, or a "
        "finite-element model (.frd, .f06, .pch, .op2, .unv, matrices in .npz or .mat, or a YAML file)",
    )
    command.add_argument(
        "--band", type=not_negative, nargs=2, metavar=("LO", "HI"), help="band in Hz, with --reference (default: all)"
    )
    command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP.format("diagnosis"))
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML report")
    add_verbosity_option(command)


def _add_predict(actions: Commands) -> None:
    command = actions.add_parser(
        "predict", help="predict the records of another campaign on the same rig from its forces"
    )
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="the diagnosed campaign")
    command.add_argument("--diagnosis", type=Path, required=True, metavar="D.json", help="diagnosis of that campaign")
    command.add_argument("--on", type=Path, required=True, metavar="OTHER", help="the campaign to predict")
    command.add_argument("--out", type=Path, required=True, metavar="PREDICTED.h5", help="the predicted records")
    command.add_argument(
        "--as-campaign", type=Path, metavar="CAMPAIGN.h5", help="also write the prediction as a campaign"
    )


def _add_revisions(actions: Commands) -> None:
    command = actions.add_parser("apply", help="write the rig's next revision, with the effects found")
    command.add_argument("diagnosis", type=Path, metavar="D.json", help="file of gap diagnose --json")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml", help="rig file of that diagnosis")
    command.add_argument("--out", type=Path, required=True, metavar="RIG2.yaml", help="the next revision")
    command.add_argument("--source", metavar="TEXT", help="the diagnosed campaign (default: the name of D.json)")
    command.set_defaults(module="gap_revisions")
    command = actions.add_parser("history", help="show how far each revision of the rig has closed the gap")
    command.add_argument("rig", type=Path, metavar="RIG.yaml", help="the latest revision")
    command.add_argument(
        "--on", type=Path, nargs="+", metavar="CAMPAIGN", help="campaigns on which to measure every revision"
    )
    command.add_argument("--json", type=Path, metavar="FILE", help="write the result as JSON")
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML page")
    command.set_defaults(module="gap_revisions")


def _add_blind(actions: Commands) -> None:
    command = actions.add_parser("blind", help="run blind trials, whose true effects are read only after all diagnoses")
    command.add_argument(
        "--out", type=Path, required=True, metavar="FOLDER", help="folder of the trials; an unfinished run is continued"
    )
    command.add_argument("--trials", type=int, default=60, metavar="N", help="number of trials with one effect")
    command.add_argument(
        "--none", type=int, metavar="N", help="number of trials without effect (default: a quarter of the others)"
    )
    command.add_argument("--pairs", type=int, default=0, metavar="N", help="number of trials with two effects")
    command.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the random numbers")
    command.add_argument("--effects", metavar="NAME,...", help="effects to draw from (default: all of the catalogue)")
    command.add_argument(
        "--tolerances",
        choices=("none", "usual"),
        default="none",
        help="errors of the simulated benches: none, or those of an ordinary lab",
    )
    command.add_argument("--no-later", action="store_true", help="do not check the diagnoses on a later campaign")
    command.add_argument(
        "--on", type=Path, metavar="CAMPAIGN", help="add known effects to these measured FRFs, of any structure"
    )
    command.add_argument(
        "--rig", type=Path, metavar="RIG.yaml", help="rig file of --on, if not in or beside that campaign"
    )
    command.add_argument(
        "--band", type=not_negative, nargs=2, metavar=("LO", "HI"), help="band of --on in Hz (default: all its lines)"
    )
    command.add_argument(
        "--folder",
        type=Path,
        metavar="CAMPAIGNS",
        help="diagnose the campaigns in this folder instead of making trials",
    )
    command.add_argument(
        "--truth", type=Path, metavar="TRUTHS", help="true effects of --folder, read after all diagnoses are written"
    )
    command.add_argument(
        "--workers", type=positive_integer, metavar="N", help="number of processes (default: one for each processor)"
    )
    command.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a Dask scheduler, whose workers can read the folder (default: none)",
    )
    command.set_defaults(module="gap_blind", out_is_folder=True)


def _add_export(actions: Commands) -> None:
    command = actions.add_parser("export", help="write the corrected simulation for other programs")
    command.add_argument("diagnosis", type=Path, metavar="D.json", help="file of gap diagnose --json")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml", help="rig file of that diagnosis")
    command.add_argument(
        "--form",
        required=True,
        choices=("npz", "mat", "mjcf", "uff"),
        help="state space for NumPy or MATLAB, MuJoCo model, modal model",
    )
    command.add_argument("--out", type=Path, required=True, metavar="FILE", help=".npz, .mat, .xml or .uff")
    command.add_argument(
        "--test", choices=("impact", "sine"), help="test to export (default: all, for mjcf the impact test)"
    )
    command.add_argument(
        "--rate", type=positive_number, metavar="HZ", help="npz and mat: also discrete in time, at this rate"
    )
    command.add_argument(
        "--on", type=Path, metavar="CAMPAIGN", help="measure the gap of the exported form to these records"
    )
    command.add_argument(
        "--records", type=positive_integer, metavar="N", help="number of records of --on (default: all held out)"
    )
    command.add_argument("--json", type=Path, metavar="FILE", help="write the measured gap as JSON")
    command.set_defaults(module="gap_export")


def _add_next(actions: Commands) -> None:
    command = actions.add_parser("next", help="plan the experiment that decides between the remaining explanations")
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="the diagnosed campaign")
    command.add_argument("--diagnosis", type=Path, required=True, metavar="D.json", help="diagnosis of that campaign")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    command.add_argument(
        "--run", dest="run_it", action="store_true", help="run the best experiment on the bench, and diagnose again"
    )
    command.add_argument("--bench", metavar="ADDRESS", help="address of the bench (default: that of the rig file)")
    command.add_argument(
        "--data", type=Path, default=Path("data"), metavar="FOLDER", help="data folder for the recordings"
    )
    command.add_argument("--out", type=Path, metavar="CAMPAIGN.h5", help="write all records as one campaign")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the new diagnosis as JSON")
    command.set_defaults(module="gap_next")

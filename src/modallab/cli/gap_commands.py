"""The commands below `modallab gap`, without importing what they do."""

from pathlib import Path

from modallab.cli.options import JSON_HELP, Commands, add_saying, not_negative, positive_integer, positive_number


def add_gap_commands(commands: Commands) -> None:
    """Add them; each names the module of `modallab.cli` that runs it."""
    gap = commands.add_parser("gap", help="say where simulation and bench differ, why, and how far that shrinks")
    actions = gap.add_subparsers(metavar="ACTION", required=True, dest="action")
    gap.set_defaults(module="gap")
    _add_diagnose(actions)
    _add_predict(actions)
    command = actions.add_parser(
        "distinguishability", help="say which effects a plan cannot distinguish, before it is run"
    )
    command.add_argument("rig", type=Path, metavar="RIG.yaml", help="its tolerances count")
    command.add_argument("plan", type=Path, metavar="PLAN.yaml", help="one test, or a list of them")
    command = actions.add_parser("effects", help="list the effects of the catalogue: what may be wrong with a bench")
    command.add_argument("names", nargs="*", metavar="EFFECT", help="describe these; default: one line each for all")
    command.set_defaults(module="effects")
    _add_revisions(actions)
    _add_export(actions)
    _add_next(actions)
    _add_blind(actions)
    command = actions.add_parser("paper", help="explain each number of the paper's Table 1")
    command.add_argument("--json", type=Path, metavar="FILE", help="write it as JSON")
    command.set_defaults(module="gap_paper")


def _add_diagnose(actions: Commands) -> None:
    command = actions.add_parser("diagnose", help="diagnose a campaign")
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="a campaign, or its folder")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    command.add_argument(
        "--hold-out",
        default="mixed",
        metavar="RULE",
        help="records kept out of the fit: mixed (one drive point of several, every third sine frequency), spread "
        "(every third hit at each point), point:N, level:NAME, test:impact, test:sine or last:SHARE",
    )
    command.add_argument(
        "--simulation", type=Path, metavar="PRED.h5", help="diagnose the simulation that predicted these records"
    )
    command.add_argument("--diagnosis", type=Path, metavar="D.json", help="of the bench, with --simulation, if known")
    command.add_argument(
        "--reference",
        type=Path,
        metavar="MODELS.json|CAMPAIGN|MODEL",
        help="of any structure: its modal model stands for the simulation, a campaign from before, or a "
        "finite-element model (.frd, .f06, .pch, .op2, .unv, matrices in .npz or .mat, or a YAML file)",
    )
    command.add_argument(
        "--band", type=not_negative, nargs=2, metavar=("LO", "HI"), help="in Hz, with --reference (default: all)"
    )
    command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP.format("diagnosis"))
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML report")
    add_saying(command)


def _add_predict(actions: Commands) -> None:
    command = actions.add_parser(
        "predict", help="predict the records of another campaign on the same rig from its forces"
    )
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="the one that was diagnosed")
    command.add_argument("--diagnosis", type=Path, required=True, metavar="D.json", help="its diagnosis")
    command.add_argument("--on", type=Path, required=True, metavar="OTHER", help="the campaign to predict")
    command.add_argument("--out", type=Path, required=True, metavar="PREDICTED.h5", help="the predicted records")
    command.add_argument("--as-campaign", type=Path, metavar="CAMPAIGN.h5", help="also as a campaign modallab reads")


def _add_revisions(actions: Commands) -> None:
    command = actions.add_parser("apply", help="write the rig's next revision, with the effects that were found")
    command.add_argument("diagnosis", type=Path, metavar="D.json", help="what gap diagnose --json wrote")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml", help="that it was diagnosed with")
    command.add_argument("--out", type=Path, required=True, metavar="RIG2.yaml", help="the next revision")
    command.add_argument("--source", metavar="TEXT", help="what was diagnosed (default: the name of D.json)")
    command.set_defaults(module="gap_revisions")
    command = actions.add_parser("history", help="show how far each revision of the rig has closed the gap")
    command.add_argument("rig", type=Path, metavar="RIG.yaml", help="the latest revision")
    command.add_argument("--on", type=Path, nargs="+", metavar="CAMPAIGN", help="measure every revision on these")
    command.add_argument("--json", type=Path, metavar="FILE", help="write it as JSON")
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML page")
    command.set_defaults(module="gap_revisions")


def _add_blind(actions: Commands) -> None:
    command = actions.add_parser(
        "blind", help="run blind trials: their true effects are read after all diagnoses are written"
    )
    command.add_argument(
        "--out", type=Path, required=True, metavar="FOLDER", help="an unfinished run in it is continued"
    )
    command.add_argument("--trials", type=int, default=60, metavar="N", help="with one effect each")
    command.add_argument("--none", type=int, metavar="N", help="without effect (default: a quarter of the others)")
    command.add_argument("--pairs", type=int, default=0, metavar="N", help="with two effects each")
    command.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the random numbers")
    command.add_argument("--effects", metavar="NAME,...", help="only these (default: all of the catalogue)")
    command.add_argument(
        "--tolerances",
        choices=("none", "usual"),
        default="none",
        help="how accurate the simulated benches are: ideal, or as in a usual lab",
    )
    command.add_argument("--no-later", action="store_true", help="do not check the diagnoses on a later campaign")
    command.add_argument(
        "--on", type=Path, metavar="CAMPAIGN", help="put known effects into these measured FRFs, of any structure"
    )
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file of --on, if not in or beside it")
    command.add_argument(
        "--band", type=not_negative, nargs=2, metavar=("LO", "HI"), help="in Hz, of --on (default: all its lines)"
    )
    command.add_argument("--folder", type=Path, metavar="CAMPAIGNS", help="diagnose these instead of making trials")
    command.add_argument(
        "--truth", type=Path, metavar="TRUTHS", help="true effects of --folder, read after all diagnoses are written"
    )
    command.add_argument("--workers", type=positive_integer, metavar="N", help="processes (default: one a processor)")
    command.add_argument("--scheduler", metavar="ADDRESS", help="of Dask, whose workers see the folder (default: none)")
    command.set_defaults(module="gap_blind", out_is_folder=True)


def _add_export(actions: Commands) -> None:
    command = actions.add_parser("export", help="write the corrected simulation for other programs")
    command.add_argument("diagnosis", type=Path, metavar="D.json", help="what gap diagnose --json wrote")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml", help="that it was diagnosed with")
    command.add_argument(
        "--form",
        required=True,
        choices=("npz", "mat", "mjcf", "uff"),
        help="state space for NumPy or MATLAB, MuJoCo model, modal model",
    )
    command.add_argument("--out", type=Path, required=True, metavar="FILE", help=".npz, .mat, .xml or .uff")
    command.add_argument("--test", choices=("impact", "sine"), help="only this one (default: all, for mjcf the impact)")
    command.add_argument("--rate", type=positive_number, metavar="HZ", help="npz and mat: in steps of this rate too")
    command.add_argument("--on", type=Path, metavar="CAMPAIGN", help="measure its gap to these records, in this form")
    command.add_argument(
        "--records", type=positive_integer, metavar="N", help="at most so many of them (default: all held out)"
    )
    command.add_argument("--json", type=Path, metavar="FILE", help="write what was measured as JSON")
    command.set_defaults(module="gap_export")


def _add_next(actions: Commands) -> None:
    command = actions.add_parser("next", help="plan the experiment that decides between the explanations that are left")
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5", help="the one that was diagnosed")
    command.add_argument("--diagnosis", type=Path, required=True, metavar="D.json", help="its diagnosis")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="rig file, if not in or beside the campaign")
    command.add_argument("--run", dest="run_it", action="store_true", help="run it on the bench, and diagnose again")
    command.add_argument("--bench", metavar="ADDRESS", help="if not the one the rig file names")
    command.add_argument("--data", type=Path, default=Path("data"), metavar="FOLDER", help="where the recordings go")
    command.add_argument("--out", type=Path, metavar="CAMPAIGN.h5", help="write all records as one campaign")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the new diagnosis as JSON")
    command.set_defaults(module="gap_next")

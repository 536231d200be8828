"""A whole test on the simulated bench, from a notebook or a script."""

import pickle
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, cast

from modallab.bench.loader import simulated_bench
from modallab.cli.demo import demo_plans, demo_rig
from modallab.core.blas_threads import one_thread
from modallab.core.errors import BenchError, ConfigurationError, ModallabError
from modallab.core.plan import Plan
from modallab.core.progress import report_progress
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.notebook.arguments import plans_of
from modallab.notebook.recording import Recording
from modallab.reporting.waiting_line import waiting_line

Numbers = Mapping[str, float | str]
PATIENCE_S = 10.0
"""What a recording takes to bring its bench to rest and to end."""


@one_thread()
def simulate(
    structure: str = "link",
    effect: str | Sequence[str] | Mapping[str, Numbers] = (),
    *,
    seed: int = 1,
    tolerances: Literal["usual", "none"] = "none",
    plan: Plan | Sequence[Plan] | str | Path | Mapping[str, object] | None = None,
    progress: bool = True,
) -> Recording:
    """Run a hammer test and a sine test on the simulated bench.

    Args:
        structure: "link", the elastic link of the demonstration.
        effect: effects of the bench: "added_mass,mass=0.05,x=0.8", several of these, or
            {"added_mass": {"mass": 0.05, "x": 0.8}}.
        seed: seed of the bench and its noise.
        tolerances: "usual" for the errors of an ordinary lab, "none" for an ideal bench.
        plan: plans instead of the demonstration's two tests: plans, their fields, or the name of a plan file.
        progress: show the progress, in a notebook or terminal.

    Raises:
        ConfigurationError: no such structure or effect.
        PlanError: the plan is impossible.
        BenchError: the recording ended early.
    """
    if structure != "link":
        raise ConfigurationError(f"no structure is called {structure!r}", remedy='give "link", the only structure')
    plans, rig = plans_of(plan) or list(demo_plans()), demo_rig()
    url = simulated_bench(rig, seed, _effects_as_texts(effect), tolerances)
    with (
        TemporaryDirectory(prefix="modallab-", ignore_cleanup_errors=True) as folder,
        waiting_line("testing", progress=progress),
    ):
        order = Path(folder) / "order.pickle"
        order.write_bytes(pickle.dumps((url, rig, plans)))
        _record_in_process(Path(folder))
        return Recording(read_campaign(Path(folder) / "campaign.h5"))


def _effects_as_texts(effect: object) -> list[str]:
    """Each effect as `added_mass,mass=0.05,x=0.8`.

    Raises:
        ConfigurationError: it is of no form that an effect can be given in.
    """
    if isinstance(effect, str):
        return [effect]
    if isinstance(effect, Mapping):
        return [_effect_as_text(pair) for pair in cast("Mapping[object, object]", effect).items()]
    return [
        _effect_as_text(one) for one in (cast("Iterable[object]", effect) if isinstance(effect, Iterable) else [effect])
    ]


def _effect_as_text(effect: object) -> str:
    match effect:
        case str():
            return effect
        case (str() as name, Mapping() as numbers):
            return ",".join([name, *(f"{k}={v}" for k, v in cast("Numbers", numbers).items())])
        case _:
            raise ConfigurationError(
                f"{effect!r} is no effect", remedy='give {"added_mass": {"mass": 0.05, "x": 0.8}}, or one text'
            )


def _record_in_process(folder: Path) -> None:
    # In a process whose main module is ours: the bench's own process would else read the caller's script once more.
    command = [sys.executable, "-m", "modallab.notebook.record", str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            for line in child.stdout:
                share, _, words = line.partition(" ")
                report_progress(float(share), words.strip())
            code = child.wait()
        except BaseException:
            _end_process(child)
            raise
    if (folder / "error.pickle").exists():
        raise cast("ModallabError", pickle.loads((folder / "error.pickle").read_bytes()))
    if code:
        raise BenchError(
            f"the recording ended with code {code}", remedy="try again; if this error repeats, run modallab demo"
        )


def _end_process(child: subprocess.Popen[str]) -> None:
    child.terminate()
    try:
        child.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        child.kill()

"""What a reader has by the time he comes to a page: files, names and devices, small and quick to make.

Each is entered as a context in the reader's folder, which holds `demo` already, and yields arguments of
`page_walk.Walk`.
"""

import io
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from added_file import added, write_example
from beam_elements import beam
from made_diagnosis import made_diagnosis
from pages import HOW_TO, ROOT, fenced
from scipy.signal import lfilter
from twin_campaign import built, link
from unsure import remaining_explanations, rig_of_sensors

import modallab as ml
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.cli import main
from modallab.cli.demo import demo_rig
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.formats import read_campaign, write_campaign, write_export
from modallab.formats.rig.rig_file import write_rig
from modallab.identification import estimators
from modallab.storage import Store, campaign_of

MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})

Made = Callable[[Path], AbstractContextManager[dict[str, Any]]]


@contextmanager
def nothing(_: Path) -> Iterator[dict[str, Any]]:
    yield {}


@contextmanager
def _readme(_: Path) -> Iterator[dict[str, Any]]:
    """FRFs of two modes at three points, and a short plan for what is simulated."""
    f = np.arange(1.0, 40.0, 0.1)
    s = 2j * np.pi * f
    noise = 1e-6 * np.random.default_rng(1).standard_normal((3, f.size))
    H = sum(
        np.multiply.outer(shape, s / (s**2 + 0.02 * omega * s + omega**2))
        for shape, omega in (([1.0, 0.8, 0.3], 60.0), ([1.0, 0.1, -0.7], 150.0))
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ml, "simulate", partial(ml.simulate, plan=ImpactPlan(points=(10, 6), hits=1)))
        yield {"names": {"f": f, "H": (H + noise)[:, None]}}


@contextmanager
def _close_the_gap(folder: Path) -> Iterator[dict[str, Any]]:
    """What the README's campaign and its diagnosis leave, small; and a diagnosis that cannot decide."""
    rig = link().model_copy(update={"bench": "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"})
    (folder / "heavy").mkdir()
    _write(folder / "heavy", built(rig, MASS, tests=("impact",)))
    found = made_diagnosis(rig, MASS)
    (folder / "heavy/gap.json").write_text(found.model_dump_json(), encoding="utf-8")
    # Where it is struck at its only sensor, nobody sees which of the two is off.
    beside = Effect(effect="hit_position", parameters={"dx": 0.01}, place={"where": "hit"})
    elsewhere = Effect(effect="position_error", parameters={"dx": 0.01}, place={"channel": 1})
    url = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0&k_root=inf&effect=hit_position,dx=0.01"
    rig = rig_of_sensors(rig, (6,)).model_copy(update={"bench": url})
    unsure = remaining_explanations(rig, beside, elsewhere)
    (folder / "unsure.json").write_text(unsure.model_dump_json(), encoding="utf-8")
    write_campaign(_recorded(rig, ImpactPlan(points=(6,), hits=2), folder / "unsure"), folder / "unsure.h5")
    (folder / "plan.yaml").write_text("{kind: impact, points: [10, 6], hits: 1}\n", encoding="utf-8")
    yield {"ran": _lines("README.md")}


def _recorded(rig: Rig, plan: ImpactPlan, data: Path) -> Campaign:
    """A test on the rig's simulated bench, in this process."""
    with Store(data) as store:
        return campaign_of(store, [record_run(open_bench(rig.bench, rig), rig, plan, store, lambda _: None)])


@contextmanager
def _first_connection(folder: Path) -> Iterator[dict[str, Any]]:
    """A bench that is simulated, and the device server of the page's first command."""
    write_rig(demo_rig().model_copy(update={"bench": "sim://cantilever?seed=1"}), folder / "rig.yaml")
    # A recording has been there, and made the data folder.
    with Store(folder / "data"):
        pass
    command = fenced(ROOT / HOW_TO / "first-connection.md")[0].lines[0]
    words = [sys.executable, *shlex.split(command)[1:]]
    with subprocess.Popen(words, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        port = json.loads(server.stdout.readline())["port"]
        yield {"ran": {command}, "words": {"bench-pc:31763": f"127.0.0.1:{port}", "FOLDER": "data"}}
        server.stdin.close()


@contextmanager
def _at_the_terminal(folder: Path) -> Iterator[dict[str, Any]]:
    """A bench that is soon at rest, a short plan, and two set-ups that share a reference."""
    rig = demo_rig().model_copy(update={"bench": "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"})
    write_rig(rig, folder / "rig.yaml")
    (folder / "plan.yaml").write_text("{kind: impact, points: [10], hits: 2}\n", encoding="utf-8")
    whole = built(link(), tests=("impact",))
    for name, rows in (("left", (0, 1, 2, 3, 10)), ("right", (0, 5, 6, 7, 10))):
        write_campaign(_of_rows(whole, rows), folder / f"session-{name}.h5")
    yield {}


def _of_rows(campaign: Campaign, rows: tuple[int, ...]) -> Campaign:
    rig = campaign.rig
    channels = tuple(rig.channels[row].model_copy(update={"index": i}) for i, row in enumerate(rows))
    at = list(rows)
    blocks = tuple(
        replace(
            b,
            samples=b.samples[at],
            scale=b.scale[at],
            units=("V",) * len(at),
            channels=tuple(c.name for c in channels),
        )
        for b in campaign.blocks
    )
    return Campaign(rig.model_copy(update={"channels": channels}), blocks, source=campaign.source)


@contextmanager
def _identify_a_band(folder: Path) -> Iterator[dict[str, Any]]:
    """Responses to a random force, of two modes: at 2000 Hz in a file, at 128 Hz as an array and in three set-ups."""
    write_campaign(ml.responses(_random(2000.0, 60.0)[:3], 2000.0, points=[1, 2, 3]).campaign, folder / "random.h5")
    for name, rows in {"left": [0, 1, 2], "middle": [0, 3, 2], "right": [0, 4, 2]}.items():
        record_run = ml.responses(_random(128.0, 100.0)[rows], 128.0, points=[row + 1 for row in rows])
        write_campaign(record_run.campaign, folder / f"{name}.h5")
    forces = np.random.default_rng(2).standard_normal((2, 25600))
    yield {"names": {"y": _random(128.0, 200.0)[:3], "forces": forces, "answers": _shaken(forces, 128.0)}}


def _random(rate_hz: float, seconds: float) -> np.ndarray:
    rng = np.random.default_rng(1)
    n = int(rate_hz * seconds)
    y = 1e-3 * rng.standard_normal((5, n))
    for hz, shape in ((9.0, [1.0, 0.8, 0.3, 0.9, 0.5]), (31.0, [1.0, 0.1, -0.7, 0.4, -0.3])):
        z = np.exp(2 * np.pi * hz * (-0.02 + 1j) / rate_hz)
        mode = lfilter([1.0], [1, -2 * z.real, abs(z) ** 2], rng.standard_normal(n))
        y += np.outer(shape, mode / mode.std())
    return y


def _shaken(forces: np.ndarray, rate_hz: float) -> np.ndarray:
    """Responses at points 1 to 3 of two modes that forces at points 1 and 3 drive."""
    answers = np.zeros((3, forces.shape[1]))
    for hz, shape in ((9.0, np.array([1.0, 0.8, 0.3])), (31.0, np.array([1.0, 0.1, -0.7]))):
        z = np.exp(2 * np.pi * hz * (-0.02 + 1j) / rate_hz)
        answers += np.outer(shape, lfilter([1.0, -1.0], [1, -2 * z.real, abs(z) ** 2], shape[[0, 2]] @ forces))
    return answers


@contextmanager
def _import(folder: Path) -> Iterator[dict[str, Any]]:
    """Files of another analyser."""
    campaign = read_campaign(folder / "demo")
    write_export(replace(campaign, blocks=campaign.of("impact")[:5]), folder / "export.uff", "uff")
    shutil.copy(folder / "demo/rig.yaml", folder / "rig.yaml")
    yield {}


@contextmanager
def _check_the_diagnosis(folder: Path) -> Iterator[dict[str, Any]]:
    """A campaign of somebody who keeps the truth: there is no effect in it."""
    (folder / "campaigns/one").mkdir(parents=True)
    (folder / "truths/one").mkdir(parents=True)
    _write(folder / "campaigns/one", built(link(), tests=("impact",)))
    (folder / "truths/one/truth.yaml").write_text("effects: []\n", encoding="utf-8")
    yield {}


@contextmanager
def _finite_elements(folder: Path) -> Iterator[dict[str, Any]]:
    """A campaign of a beam, and the beam's matrices with what says so."""
    rig = link()
    assert rig.beam is not None
    write_campaign(built(rig, tests=("impact",)), folder / "campaign.h5")
    per_m = rig.beam.mass_kg / rig.beam.length_m
    names = ("K", "M", "freedoms", "nodes")
    made = beam(rig.beam.bending_stiffness_n_m2, per_m, rig.beam.length_m, 20)
    np.savez(folder / "beam.npz", **dict(zip(names, made, strict=True)))
    said = "\n".join(f"{what}: beam.npz" for what in ("stiffness", "mass", "freedoms", "nodes"))
    (folder / "model.yaml").write_text(said, encoding="utf-8")
    yield {}


@contextmanager
def _let_people_in(folder: Path) -> Iterator[dict[str, Any]]:
    """The service has run once; the token that is taken back is one that was given before."""

    def token() -> str:
        said = io.StringIO()
        with redirect_stdout(said):
            main(["user", "list", "--data", str(folder / "lab-data")])
        return next(word for word in re.findall(r"\b[0-9a-f]{12}\b", said.getvalue()))

    Store(folder / "lab-data").close()
    yield {"words": {"4f1c09ab77e2": token}}


@contextmanager
def _add_an_estimator(folder: Path) -> Iterator[dict[str, Any]]:
    (folder / "more").mkdir()
    write_example("add-an-estimator.md", folder / "more/phase_slope.py")
    with added(estimators, folder / "more"):
        yield {}


def _write(folder: Path, campaign: Campaign) -> None:
    write_campaign(campaign, folder / "campaign.h5")
    write_rig(campaign.rig, folder / "rig.yaml")


def _lines(page: str) -> set[str]:
    """The commands of a page."""
    return {line.removeprefix("$ ") for block in fenced(ROOT / page) for line in block.lines if line.startswith("$ ")}


PREPARED: dict[str, Made] = {
    "README.md": _readme,
    HOW_TO + "add-an-estimator.md": _add_an_estimator,
    HOW_TO + "check-the-diagnosis.md": _check_the_diagnosis,
    HOW_TO + "close-the-gap.md": _close_the_gap,
    HOW_TO + "compare-with-finite-elements.md": _finite_elements,
    HOW_TO + "first-connection.md": _first_connection,
    HOW_TO + "identify-a-band.md": _identify_a_band,
    HOW_TO + "import-recordings.md": _import,
    HOW_TO + "let-people-in.md": _let_people_in,
    HOW_TO + "strike-at-the-terminal.md": _at_the_terminal,
}

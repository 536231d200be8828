"""What all tests share."""

import gc
import os
import sys
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from compiled_once import compiled_once
from files_together import pytest_xdist_make_scheduler
from hypothesis import settings
from made_once import made_once, record_demo, write_small
from postgresql_server import Server, postgresql_server
from slowest_tests import pytest_addoption, pytest_configure

__all__ = ["pytest_addoption", "pytest_configure", "pytest_xdist_make_scheduler"]

ROOT = Path(__file__).parent.parent

# As `make` and the commands do: before anything imports NumPy, which reads it once.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
# Each of the many processes that tests start would else compile all sources again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# How long an example takes says nothing where other programs compute.
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")

SLOW_FILES = (
    "service/campaigns/test_session.py",
    "page/test_the_page.py",
    "page/test_a_campaign_by_page.py",
    "service/api/test_live.py",
    "docs/test_commands.py",
    "identification/test_more_data.py",
    "gap/test_corpus.py",
    "pipelines/test_two_references.py",
    "cli/test_by_reference.py",
    "gap/test_one_channel.py",
    "docs/test_site.py",
    "notebook/test_put_to_use.py",
    "gap/test_contradictions.py",
    "blind/test_trials_on_a_structure.py",
    "drivers/test_local_mode.py",
    "service/process/test_token.py",
    "service/process/test_kills.py",
    "service/process/test_a_session.py",
    "service/process/test_leaving.py",
    "cli/test_ctrl_c.py",
    "drivers/test_supervisor.py",
    "acquisition/test_controls.py",
    "acquisition/test_process.py",
    "gap/test_diagnose.py",
    "gap/test_as_built.py",
    "gap/test_own_bench.py",
    "gap/test_acting.py",
    "gap/test_selection.py",
    "reporting/test_report.py",
    "identification/test_impact.py",
    "notebook/test_people.py",
    "contract/test_bench_contract.py",
    "service/api/test_schemathesis.py",
    "service/process/test_tutorial.py",
    "jobs/test_runner.py",
    "jobs/test_many_machines.py",
    "jobs/test_kinds.py",
    "jobs/test_docker.py",
    "acquisition/test_owner_death.py",
    "gap/unknown/test_behaves_like.py",
    "gap/unknown/test_spare_poles.py",
    "pipelines/test_kinds_of_frf.py",
    "conventions/test_other_chains.py",
    "conventions/test_same_answers.py",
    "simulators/test_trials_show.py",
    "simulators/test_add_an_effect.py",
    "identification/test_choice.py",
    "identification/test_estimators.py",
)
"""The longest first: the short ones at the end are shared out, and all workers end together. The very first makes the
recording that others read.
"""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Two more than there are cores: many tests wait, for a process to begin or for a device's own clock."""
    return (os.cpu_count() or 1) + 2


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Modules and tests are no garbage: to look through them again and again takes each worker seconds."""
    gc.disable()
    try:
        with compiled_once(session.config):
            return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    place = {ROOT / "tests" / file: n for n, file in enumerate(SLOW_FILES)}
    items.sort(key=lambda item: place.get(item.path, len(place)))
    for item in items:
        _require_reason(item)


def _require_reason(item: pytest.Item) -> None:
    for mark in item.iter_markers("thorough"):
        if len(mark.args) != 1 or not isinstance(mark.args[0], str) or mark.kwargs:
            raise pytest.UsageError(f"{item.nodeid}: thorough{mark.args} says no reason: what takes so long?")


@pytest.fixture(scope="session")
def practice() -> Path:
    """Folder of the practice campaigns, which are not part of the project."""
    folder = Path(os.environ.get("MODALLAB_PRACTICE", ROOT.parent / "shared" / "practice"))
    if not folder.is_dir():
        pytest.skip("the practice campaigns are not here")
    return folder


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of `modallab demo --out demo`, to be read only; beside it stands what the command printed."""
    return made_once(tmp_path_factory, "recorded", record_demo) / "demo"


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a campaign that the twin made: 6 hits, 24 sines and the rig file, to be read only."""
    return made_once(tmp_path_factory, "small", write_small)


@pytest.fixture(scope="session")
def postgresql() -> Iterator[Server]:
    with postgresql_server() as server:
        yield server

"""What all tests share."""

import os
import sys
from pathlib import Path

import pytest
from made_once import made_once, record_demo

ROOT = Path(__file__).parent.parent

# As `make` and the commands do: before anything imports NumPy, which reads it once.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
# Each of the many processes that tests start would else compile all sources again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

SLOW_FILES = (
    "docs/test_commands.py",
    "service/process/test_kills.py",
    "service/process/test_tutorial.py",
    "service/api/test_schemathesis.py",
    "page/test_a_campaign_by_page.py",
    "page/test_the_page.py",
    "page/test_service_gone.py",
    "jobs/test_many_machines.py",
    "jobs/test_runner.py",
    "drivers/test_supervisor.py",
    "acquisition/test_owner_death.py",
    "gap/test_diagnose.py",
    "simulators/test_add_an_effect.py",
    "simulators/test_trials_show.py",
    "gap/test_own_bench.py",
    "acquisition/test_process.py",
    "identification/test_impact.py",
)
"""The longest first: `--dist worksteal` then shares out the short ones at the end, and all workers end together."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """One more than there are cores: many tests wait, for a process to begin or for a device's own clock."""
    return (os.cpu_count() or 1) + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    place = {ROOT / "tests" / file: n for n, file in enumerate(SLOW_FILES)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


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

"""What all tests share."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# As `make` and the commands do: before anything imports NumPy, which reads it once.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")


@pytest.fixture(scope="session")
def practice() -> Path:
    """Folder of the practice campaigns, which are not part of the project."""
    folder = Path(os.environ.get("MODALLAB_PRACTICE", ROOT.parent / "shared" / "practice"))
    if not folder.is_dir():
        pytest.skip("the practice campaigns are not here")
    return folder

"""Fixtures of those who test the service."""

from collections.abc import Iterator
from importlib import resources

import pytest
from lab import Lab

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig


@pytest.fixture(scope="session")
def link_rig() -> Rig:
    return parse_rig((resources.files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link")


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    """One for all tests of a worker: a rig with well damped modes, so that the beam soon rests."""
    with Lab(tmp_path_factory.mktemp("lab") / "data", link_rig, "sim://cantilever?seed=1&zeta=0.05&bad_hits=0") as made:
        made.wait_until_idle()
        yield made

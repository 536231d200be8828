"""Fixtures of those who test the service."""

from collections.abc import Iterator
from importlib import resources

import pytest
from lab import RIG, Lab

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig


@pytest.fixture(scope="session")
def link_rig() -> Rig:
    return parse_rig((resources.files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link")


URL = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
"""Modes are well damped, so that the beam soon rests."""


# Not for the session: a service that nobody asks any more would take a twentieth of a processor from all other tests.
@pytest.fixture(scope="package")
def labs() -> list[Lab]:
    """The service that the tests of this folder share, once one has asked for it."""
    return []


@pytest.fixture(scope="package")
def lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig, labs: list[Lab]) -> Iterator[Lab]:
    """One service and rig for all tests of a folder; each makes campaigns of its own."""
    with Lab(tmp_path_factory.mktemp("lab") / "data", link_rig, URL) as made:
        made.wait_until_idle()
        labs.append(made)
        yield made
        labs.remove(made)


@pytest.fixture(scope="module", autouse=True)
def lease_given_back(labs: list[Lab]) -> Iterator[None]:
    """No file leaves the next one a rig that somebody holds."""
    yield
    for lab in labs:
        leases = lab.service.leases
        leases.release(RIG, leases.take(RIG, "Ada", 1.0, take_over=True).id)

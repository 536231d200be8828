"""The demo's rig, and a simulated NI server in another process."""

from collections.abc import Iterator
from importlib.resources import files

import pytest
from ni_server import NiServer

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@pytest.fixture(scope="module")
def ni_server(rig: Rig) -> Iterator[NiServer]:
    with NiServer(rig, "9215") as server:
        server.say("preamplifiers sine")
        yield server

"""The benches the contract is compared with, one after the other."""

import sys
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import pytest
from added_file import write_example
from ni_server import NiServer
from pages import ROOT, fenced

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench
from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import parse_rig

SIMULATED = "sim://cantilever?seed=1&bad_hits=0"
RECORDED_S = 12.0
BENCHES = ["sim", "replay", "nidaqmx+grpc", "daqref", "still"]


@pytest.fixture(scope="session")
def rig() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@pytest.fixture(scope="session")
def recording(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign with one long block of each test, as the simulated bench delivered it."""
    bench = open_bench(SIMULATED, rig)
    blocks = tuple(
        _recorded(bench, rig, AcquisitionRequest(test, rate)) for test, rate in (("impact", 2000.0), ("sine", 1000.0))
    )
    bench.close()
    folder = tmp_path_factory.mktemp("recording")
    write_campaign(Campaign(rig, blocks), folder / "campaign.h5")
    return folder


@pytest.fixture(scope="module")
def ni_server(rig: Rig) -> Iterator[NiServer]:
    """NI's gRPC device server, simulated, in another process."""
    with NiServer(rig, "9215") as server:
        # The preamplifiers' knobs are turned by hand.
        server.say("preamplifiers sine")
        yield server


@pytest.fixture
def still(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The driver of docs/how-to/add-a-driver.md, as a package of its own that was installed."""
    write_example("add-a-driver.md", tmp_path / "still_bench.py")
    installed = tmp_path / "still_bench-1.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: still-bench\nVersion: 1\n")
    (line,) = (b.lines for b in fenced(ROOT / "docs/how-to/add-a-driver.md") if b.language == "toml")
    entry = "\n".join(line).replace('[project.entry-points."modallab.backends"]', "[modallab.backends]")
    (installed / "entry_points.txt").write_text(entry.replace('"', "") + "\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield "still://here"
    sys.modules.pop("still_bench", None)


@pytest.fixture
def addresses(request: pytest.FixtureRequest) -> dict[str, str]:
    """Address of each kind of bench; what a kind needs is made on first use."""
    kind = request.node.callspec.params["kind"]
    return {kind: _ADDRESS[kind](request)}


@pytest.fixture(params=BENCHES)
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def bench(kind: str, addresses: dict[str, str], rig: Rig) -> Iterator[Bench]:
    opened = open_bench(addresses[kind], rig)
    yield opened
    opened.close()


def _recorded(bench: Bench, rig: Rig, request: AcquisitionRequest) -> Block:
    test: Test = request.test
    delivery = bench.configure(request)
    bench.start()
    bench.prompt_hit(rig.points[-1].id)
    count = round(RECORDED_S * delivery.rate_hz)
    samples = bench.read(count, RECORDED_S).samples
    bench.stop()
    return Block(
        name=f"{test}_1",
        test=test,
        order=0 if test == "impact" else 1,
        rate_hz=delivery.rate_hz,
        samples=samples,
        scale=delivery.scale,
        units=delivery.units,
        channels=tuple(c.name for c in rig.channels),
    )


_ADDRESS = {
    "sim": lambda request: SIMULATED,
    "replay": lambda request: f"replay://{request.getfixturevalue('recording')}?speed=0",
    "daqref": lambda request: "daqref://device0",
    "still": lambda request: request.getfixturevalue("still"),
    "nidaqmx+grpc": lambda request: request.getfixturevalue("ni_server").url,
}

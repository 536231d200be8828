"""The demonstration rig and a way to run its simulated bench."""

from collections.abc import Callable, Iterator
from importlib.resources import files

import pytest

from modallab.bench.protocol import AcquisitionRequest, Bench
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab_simulators.cantilever import open_bench

Running = Callable[..., Bench]


@pytest.fixture(scope="session")
def rig() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@pytest.fixture
def running(rig: Rig) -> Iterator[Running]:
    """Opens, configures and starts benches of the demonstration rig."""
    benches: list[Bench] = []

    def open_running(query: str = "seed=1", test: str = "impact", rate_hz: float = 2000.0) -> Bench:
        bench = open_bench(f"sim://cantilever?{query}", rig)
        benches.append(bench)
        bench.configure(AcquisitionRequest(test, rate_hz))
        bench.start()
        return bench

    yield open_running
    for bench in benches:
        bench.close()

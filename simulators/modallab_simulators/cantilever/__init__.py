"""The simulated bench `sim://cantilever`: a beam with hammer, shaker, sensors and converter, by modal superposition."""

from modallab.bench.protocol import Bench
from modallab.core.rig import Rig
from modallab_simulators.cantilever.address import parse_address
from modallab_simulators.cantilever.bench import CantileverBench


def open_bench(url: str, rig: Rig) -> Bench:
    """Open the simulated bench.

    Raises:
        ConfigurationError: the address is not understood, or the rig describes no such bench.
    """
    return CantileverBench(url, rig, parse_address(url))

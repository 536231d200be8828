"""A sine generator that speaks SCPI over a pseudo-terminal or a socket, on the clock of a simulated bench.

Four makers' languages are understood, each strictly, and each with what the makers' guides leave out.
"""

from modallab_simulators.scpi_generator.device import ScpiGenerator
from modallab_simulators.scpi_generator.ports import HislipGenerator, PtyGenerator, SocketGenerator
from modallab_simulators.scpi_generator.settings import SINE_DIALECTS

__all__ = ["SINE_DIALECTS", "HislipGenerator", "PtyGenerator", "ScpiGenerator", "SocketGenerator"]

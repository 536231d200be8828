"""Whose clock and trigger a task runs by, so that cards agree as far as they are wired to and no further.

Without a shared clock each card has its own rate, within some ppm; without a shared trigger each starts when its
software does; and converters that oversample begin anywhere in a sample, unless a sync pulse has aligned them.
"""

from dataclasses import dataclass, field
from zlib import crc32

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import domain, own_ppm, pxi_chassis
from modallab_simulators.ni_daqmx_server.tasks import Task

SOFTWARE_S = 2e-3
"""Two starts by software are up to so long apart."""
BACKPLANE = ("PXI_CLK10", "PXIE_CLK100")
NETWORKED = ("cDAQ-9185", "cDAQ-9189")


@dataclass(slots=True)
class Clocks:
    """The clocks of a system.

    Attributes:
        several: whether there is more than one; a lone device is the bench's own clock.
        networked: chassis that keep one time over the network.
        phases: where in a sample each device's converters begin, in parts of it.
    """

    several: bool
    networked: frozenset[str]
    phases: dict[str, float] = field(default_factory=dict[str, float])
    _draw: np.random.Generator = field(default_factory=lambda: np.random.default_rng(20))

    def require_one_task(self, modules: tuple[Module, ...]) -> None:
        """Reject a task over devices that cannot be in one.

        Raises:
            StatusError: they share neither a chassis nor a backplane.
        """
        found = {domain(m) for m in modules}
        if len(found) <= 1 or found <= self.networked:
            return
        backplanes = {pxi_chassis(m.name) for m in modules}
        if len(backplanes) > 1 or "" in backplanes:
            raise StatusError(status.MULTI_DEVICES, f"Devices: {', '.join(sorted(found))}")

    def ppm(self, task: Task) -> float:
        """What the rate of a task, of inputs or of outputs, is off by."""
        if not self.several:
            return 0.0
        module = task.all_channels()[0].module
        for attribute in ("SAMP_CLK_SRC", "SAMP_CLK_TIMEBASE_SRC"):
            lent = _device_of(task.routed(attribute))
            if lent and lent not in _devices(task):
                return self._device_ppm(lent)
        reference = task.routed("REF_CLK_SRC").rpartition("/")[2].upper()
        if reference in BACKPLANE or len({c.module.name for c in task.all_channels()}) > 1:
            return self._device_ppm(pxi_chassis(module.name) or domain(module))
        lent = _device_of(task.routed("REF_CLK_SRC"))
        return self._device_ppm(lent or domain(module))

    def phase(self, task: InputTask) -> float:
        """Where in a sample a task begins, in parts of it."""
        if not self.several or not any(m.delta_sigma for m in task.modules):
            return 0.0
        own = domain(task.modules[0])
        lent = _device_of(task.routed("SYNC_PULSE_SRC"))
        locked = bool(task.get("REF_CLK_SRC") or task.get("SAMP_CLK_TIMEBASE_SRC"))
        if lent and locked and lent in self.phases:
            self.phases[own] = self.phases[lent]
        else:
            self.phases[own] = float(self._draw.uniform())
        return self.phases[own]

    def software_s(self) -> float:
        """How much later than asked for a start by software is."""
        return float(self._draw.uniform(0.0, SOFTWARE_S)) if self.several else 0.0

    def _device_ppm(self, device: str) -> float:
        name = "network" if device in self.networked else device
        return own_ppm(crc32(name.encode()))


def _device_of(source: str) -> str:
    return source.split("/")[1] if source.startswith("/") and source.count("/") > 1 else ""


def _devices(task: Task) -> set[str]:
    return {name for channel in task.all_channels() for name in (channel.module.name, channel.module.chassis)}

"""The bytes between an instrument and whoever speaks to it, with all that goes wrong there."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from modallab_simulators import faults
from modallab_simulators.scpi_generator.device import ScpiGenerator

Write = Callable[[bytes], object]


class Link:
    """Cuts what comes into lines, lets the instrument obey, and sends what it answers."""

    def __init__(self, device: ScpiGenerator) -> None:
        self._device = device
        self._pending = b""
        self._fault, self._slow_s, self._late_s = "", 0.0, 0.0

    def fault(self, line: str) -> None:
        """Arm a fault, such as `clipped-set-point 0.1`, `front-panel amplitude 5`, `late-answer 1.5`.

        Raises:
            ValueError: a generator cannot have it.
        """
        kind, words = faults.parse(line, faults.GENERATOR_FAULTS)
        if kind == faults.CLIPPED:
            self._device.clip_vpp = float(words[0])
        elif kind == faults.COERCED:
            self._device.gain = float(words[0])
        elif kind == faults.FRONT_PANEL:
            self._device.panel(words[0], words[1])
        elif kind == faults.POWER_CYCLE:
            self._device.power_cycle()
        elif kind == faults.STAYS_ON:
            self._device.deaf = words[0] if words else "always"
        elif kind == faults.SLOW:
            self._slow_s = float(words[0])
        elif kind == faults.LATE:
            self._late_s = float(words[0])
        else:
            self._fault = kind

    def take(self, data: bytes, write: Write) -> None:
        """Bytes came in."""
        *lines, self._pending = (self._pending + data).split(b"\n")
        for line in lines:
            if self._fault not in (faults.DEAD_LINE, faults.TIME_OUT):
                self._obey(line, write)

    def _obey(self, line: bytes, write: Write) -> None:
        answer = self._device.ask(line.decode("ascii", "replace").strip())
        if self._fault == faults.ECHO:
            write(line + b"\n")
        if answer is None:
            return
        late_s, self._late_s = self._late_s, 0.0
        time.sleep(self._slow_s + late_s)
        write(self._spoilt(answer.encode("ascii")))

    def _spoilt(self, answer: bytes) -> bytes:
        if self._fault == faults.GARBAGE:
            return bytes(byte ^ 0xA5 for byte in answer) + b"\n"
        if self._fault == faults.CUT_OFF:
            return answer[: len(answer) // 2]
        if self._fault == faults.TERMINATOR:
            return answer + b"\r"
        return answer + b"\n"


class Port(ABC):
    """Where a generator can be reached."""

    port: str

    def __init__(self, device: ScpiGenerator) -> None:
        self._link = Link(device)

    def fault(self, line: str) -> None:
        """Arm a fault; see `Link.fault`. `unplugged` cuts every connection."""
        if line == faults.UNPLUGGED:
            self.close()
        else:
            self._link.fault(line)

    @abstractmethod
    def close(self) -> None:
        """Cut every connection."""

"""A serial line of text, question by question."""

import serial

from modallab.core.errors import DeviceGoneError

TIMEOUT_S = 1.0
_REMEDY = "look at the cable, the port, the baud rate and the instrument's remote setting"


class SerialLine:
    """One open port."""

    def __init__(self, port: str, baud: int) -> None:
        """Open it.

        Raises:
            DeviceGoneError: there is no such port, or it is taken.
        """
        self.port = port
        try:
            self._serial = serial.Serial(port, baud, timeout=TIMEOUT_S, write_timeout=TIMEOUT_S)
        except (serial.SerialException, ValueError) as error:
            raise DeviceGoneError(f"the port cannot be opened: {error}", where=self._where, remedy=_REMEDY) from error

    @property
    def _where(self) -> str:
        return f"generator on {self.port} (rig file field excitation.output)"

    def send(self, text: str) -> None:
        """Send a line.

        Raises:
            DeviceGoneError: the line is dead.
        """
        try:
            self._serial.write(f"{text}\n".encode("ascii"))
        except (serial.SerialException, OSError) as error:
            raise self._gone(text, str(error)) from error

    def ask(self, text: str) -> str:
        """Send a line and wait for the answer.

        Raises:
            DeviceGoneError: the line is dead, or nothing came in time.
        """
        self.send(text)
        try:
            answer = self._serial.read_until(b"\n")
        except (serial.SerialException, OSError) as error:
            raise self._gone(text, str(error)) from error
        if not answer.endswith(b"\n"):
            raise self._gone(text, f"no answer within {TIMEOUT_S:g} s")
        return answer.decode("ascii", "replace").strip()

    def close(self) -> None:
        """Let go of the port."""
        self._serial.close()

    def _gone(self, text: str, why: str) -> DeviceGoneError:
        return DeviceGoneError(f"{text!r}: {why}", where=self._where, remedy=_REMEDY)

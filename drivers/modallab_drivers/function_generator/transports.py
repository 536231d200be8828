"""The ways to an instrument: a serial port, or USB and LAN by VISA. Each moves lines and knows nothing of them."""

from collections.abc import Generator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

END = b"\n"


class Transport(Protocol):
    """An open way to one instrument. Every method may raise OSError: the way is dead."""

    def write(self, lines: bytes) -> None:
        """Send whole lines."""
        ...

    def read(self, timeout_s: float) -> tuple[bytes, bool]:
        """What came up to the end of a line, and whether that end came within the time-out."""
        ...

    def discard_input(self) -> None:
        """Forget what has already come."""
        ...

    def close(self) -> None:
        """Let go."""
        ...


def is_visa(address: str) -> bool:
    """Whether an address is a VISA resource: `TCPIP0::192.168.0.5::INSTR`, `USB0::...`; else it is a serial port."""
    return address.upper().startswith(("TCPIP", "USB")) and "::" in address


def open_transport(address: str, baud: int, timeout_s: float) -> Transport:
    """The way to an address.

    Raises:
        OSError: there is no such port, nobody answers at the address, or it is taken.
        ValueError: the address is not one.
    """
    return VisaResource(address, timeout_s) if is_visa(address) else SerialPort(address, baud, timeout_s)


class SerialPort:
    """By pyserial."""

    def __init__(self, port: str, baud: int, timeout_s: float) -> None:
        import serial

        self._serial = serial.Serial(port, baud, timeout=timeout_s, write_timeout=timeout_s)

    def write(self, lines: bytes) -> None:
        """Send lines."""
        self._serial.write(lines)

    def read(self, timeout_s: float) -> tuple[bytes, bool]:
        """Up to a line feed."""
        if self._serial.timeout != timeout_s:
            self._serial.timeout = timeout_s
        line: bytes = self._serial.read_until(END)
        return line, line.endswith(END)

    def discard_input(self) -> None:
        """Empty the port's buffer."""
        try:
            self._serial.reset_input_buffer()
        except OSError:
            raise
        except Exception as error:
            # The terminal's own error of a plug that was pulled is no OSError.
            raise OSError(str(error)) from error

    def close(self) -> None:
        """Let go of the port."""
        self._serial.close()


class VisaResource:
    """By pyvisa with its backend in Python: no vendor's library is needed."""

    def __init__(self, address: str, timeout_s: float) -> None:
        import pyvisa
        from pyvisa import constants, errors

        self._errors: Any = errors
        self._timed_out: Any = constants.StatusCode.error_timeout
        milliseconds = round(1000 * timeout_s)
        with self._as_os_error():
            resource: Any = pyvisa.ResourceManager("@py").open_resource(
                address, open_timeout=milliseconds, timeout=milliseconds
            )
        self._resource = resource
        self._messages = not address.upper().endswith("::SOCKET")
        if not self._messages:
            # A bare socket has no end of a message but the line feed.
            self._resource.read_termination = "\n"

    def write(self, lines: bytes) -> None:
        """Send each line as a message, or all at once where nothing but line feeds ends them."""
        with self._as_os_error():
            for each in lines.splitlines(keepends=True) if self._messages else [lines]:
                self._resource.write_raw(each)

    def read(self, timeout_s: float) -> tuple[bytes, bool]:
        """A message, whose end the protocol marks; on a bare socket a line."""
        with self._as_os_error():
            self._resource.timeout = max(1, round(1000 * timeout_s))
            try:
                # Where nothing was asked the backend's HiSLIP does not wait: it gives an empty message at once.
                message = bytes(self._resource.read_raw())
                return message, bool(message)
            except self._errors.VisaIOError as error:
                if error.error_code != self._timed_out:
                    raise
                return b"", False

    def discard_input(self) -> None:
        """Nothing to do: what came too late is read away by whoever waits for its own answer."""

    def close(self) -> None:
        """Let go of it."""
        with suppress(Exception):
            self._resource.close()

    @contextmanager
    def _as_os_error(self) -> Generator[None]:
        # The backend raises whatever its protocol does, and a bare Exception where nobody answers.
        try:
            yield
        except OSError:
            raise
        except Exception as error:
            raise OSError(str(error) or type(error).__name__) from error

"""NI-DAQmx devices, on this machine (`nidaqmx://cDAQ1`) or behind NI's gRPC device server.

`nidaqmx+grpc://host:port/cDAQ1?tls=ca.crt`: the package `nidaqmx` is used unchanged by both routes. It is imported when
such an address is opened.
"""

from modallab.bench.protocol import Bench, FoundDevice, OutputHandle
from modallab.core.errors import BenchError
from modallab.core.rig import Rig


def open_bench(url: str, rig: Rig) -> Bench:
    """Open the devices at an address, with the excitation's output at 0 V.

    Raises:
        ConfigurationError: the address, or a field of the rig file that does not fit the devices.
        DeviceGoneError: no driver, no server, no device.
        DeviceBusyError: another program holds the output.
    """
    from modallab_drivers.ni_daqmx.bench import NiBench

    return NiBench(url, rig)


def open_output(url: str, rig: Rig) -> OutputHandle:
    """A second handle to the excitation's output, which can only bring it to 0 V.

    Raises:
        ConfigurationError: the address is not understood.
    """
    from modallab_drivers.ni_daqmx.second_handle import SecondHandle

    return SecondHandle(url, rig)


def find_devices(address: str) -> list[FoundDevice]:
    """NI devices of this machine, or of the server at an address.

    Raises:
        DeviceGoneError: the server at the address does not answer.
    """
    from modallab_drivers.ni_daqmx.route import found_devices

    try:
        return found_devices(address or "nidaqmx://")
    except BenchError:
        if address:
            raise
        return []

"""`modallab devices`: what is there, and giving back what a killed program has left reserved."""

import argparse

from rich.console import Console

from modallab.bench.loader import find_devices, open_output
from modallab.core.errors import ConfigurationError
from modallab.formats.rig.rig_file import read_rig


def run(arguments: argparse.Namespace) -> int:
    """List devices, or release one."""
    console = Console()
    if arguments.release:
        return _release(console, arguments)
    for found in find_devices(arguments.address):
        console.print(f"{found.address:<44} {found.what}", markup=False, highlight=False)
    return 0


def _release(console: Console, arguments: argparse.Namespace) -> int:
    if not arguments.address or arguments.rig is None:
        raise ConfigurationError("nothing to release", remedy="modallab devices ADDRESS --release --rig RIG.yaml")
    handle = open_output(arguments.address, read_rig(arguments.rig))
    if handle is None:
        raise ConfigurationError(
            f"{arguments.address} keeps no reservation after its program has ended", remedy="just start again"
        )
    try:
        handle.release()
    finally:
        handle.close()
    console.print(f"{arguments.address}: the output is at 0 V, and reserved devices are released", markup=False)
    return 0

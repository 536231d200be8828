"""An environment of its own for the vendor's package, and the simulated server that its programs speak to."""

import os
import subprocess
import sys
import venv
from importlib.resources import files
from pathlib import Path

EXTRAS = ("pytest", "pytest-mock", "pytest-timeout", "matplotlib", "nptdms")
RIG = Path(str(files("modallab.cli"))) / "link_rig.yaml"
REAL_DEVICES = Path(__file__).with_name("real_devices.ini")


def interpreter(folder: Path, checkout: Path) -> Path:
    """The Python of the environment in `folder`, made there if it is not yet.

    Raises:
        subprocess.CalledProcessError: a package could not be installed.
    """
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", f"{checkout}[grpc]", *EXTRAS], check=True)
    return python


def server_command(checkout: Path) -> list[str]:
    """The simulated server, with the devices that the vendor's configuration files describe."""
    described = [*sorted((checkout / "tests" / "max_config").glob("*.ini")), REAL_DEVICES]
    return [
        sys.executable, "-m", "modallab_simulators.ni_daqmx_server", "--cables", "--pace", f"--rig={RIG}",
        *(f"--devices={file}" for file in described),
    ]  # fmt: skip

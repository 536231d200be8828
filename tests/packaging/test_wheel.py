"""The wheel holds what the checkout holds, and works away from it."""

import os
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Mapping
from configparser import ConfigParser
from email.parser import Parser
from pathlib import Path

import pytest

pytestmark = pytest.mark.thorough("builds a wheel")

ROOT = Path(__file__).parents[2]
PACKAGES = ("src/modallab", "drivers/modallab_drivers", "simulators/modallab_simulators")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built without a network, by what the development environment holds."""
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", str(out), str(ROOT)]
    done = subprocess.run(command, cwd=out, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def unpacked(wheel: Path) -> Path:
    folder = wheel.parent / "unpacked"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def project() -> Mapping[str, object]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_it_holds_every_file_of_the_three_packages_and_no_other(unpacked: Path) -> None:
    here = {
        file.relative_to((ROOT / package).parent).as_posix()
        for package in PACKAGES
        for file in (ROOT / package).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    there = {file.relative_to(unpacked).as_posix() for file in unpacked.rglob("*") if file.is_file()}
    assert {name for name in there if ".dist-info/" not in name} == here
    assert {"modallab/cli/link_rig.yaml", "modallab/reporting/report.css", "modallab/reporting/motion.js"} <= there


def test_its_entry_points_are_those_of_the_project(unpacked: Path, project: Mapping[str, dict]) -> None:
    names = ConfigParser(delimiters=("=",))
    names.read(next(unpacked.glob("*.dist-info")) / "entry_points.txt", encoding="utf-8")
    assert dict(names["console_scripts"]) == project["scripts"]
    for group, entries in project["entry-points"].items():
        assert dict(names[group]) == entries


def test_its_metadata_name_licence_readme_and_python(unpacked: Path) -> None:
    folder = next(unpacked.glob("*.dist-info"))
    metadata = Parser().parsestr((folder / "METADATA").read_text(encoding="utf-8"))
    assert metadata["License-Expression"] == "MIT"
    assert metadata["Requires-Python"] == ">=3.11"
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload().startswith("# modallab")
    assert (folder / "licenses" / "LICENSE").read_text(encoding="utf-8").startswith("MIT License")


def test_it_works_away_from_the_checkout(unpacked: Path) -> None:
    """Every module can be imported, every entry point loaded, and the packages' own files are found."""
    code = """
import importlib, pkgutil, sys
from importlib.metadata import entry_points
from modallab.cli.demo import demo_rig
from modallab.reporting import report
import modallab, modallab_drivers, modallab_simulators
packages = (modallab, modallab_drivers, modallab_simulators)
for package in packages:
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
for group in ("modallab.backends", "modallab.outputs"):
    for entry in entry_points(group=group):
        entry.load()
print(*(package.__file__ for package in packages), demo_rig().shaker_point, sep="\\n")
"""
    environment = os.environ | {"PYTHONPATH": str(unpacked), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=unpacked.parent,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *files, shaker_point = done.stdout.split()
    assert all(Path(file).is_relative_to(unpacked) for file in files)
    assert shaker_point == "4"

"""Nastran's binary results: what is read is what the same run printed."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from modallab.core.discovery import EXTRAS, how_to_install
from modallab.core.errors import DataError, FormatError, MissingPackageError
from modallab.formats.fem import nastran_op2
from modallab.formats.fem.fem_file import is_fem, read_fem

BEAM = Path(__file__).parents[1] / "data" / "nastran" / "beam_modes.op2"
PRINTED_HZ = (456.66035253, 456.66035253, 2674.58733542, 2674.58733542, 3554.92294432)
PRINTED = {2: (0.0809108032, 3.9148811013), 5: (12.2730459789, 133.748199858), 11: (234.484822346, 109.487173853)}
"""Node -> squares of the motion in the first and in the second pair of modes, at unit modal mass. The beam is round:
how each pair lies about the axis is by chance."""


def test_modes_are_those_that_were_printed_at_unit_modal_mass() -> None:
    assert is_fem(BEAM)
    found = read_fem(BEAM).modes
    np.testing.assert_allclose(found.frequency_hz[:5], PRINTED_HZ, rtol=1e-6)
    for node, squares in PRINTED.items():
        motion = found.at[node] ** 2
        np.testing.assert_allclose([motion[:2].sum(), motion[2:4].sum()], squares, rtol=1e-5)
    assert found.places_m[5] == pytest.approx((4.0, 0.0, 0.0))
    assert set(found.places_m) == set(found.at)


@pytest.mark.thorough("starts Python anew with a large library")
def test_numbers_are_printed_afterwards_as_before() -> None:
    script = (
        "import sys, numpy as np; from pathlib import Path; from modallab.formats.fem.fem_file import read_fem;"
        "before = np.get_printoptions(); read_fem(Path(sys.argv[1]));"
        "assert 'pyyeti' in sys.modules; assert np.get_printoptions() == before"
    )
    subprocess.run([sys.executable, "-c", script, str(BEAM)], check=True, timeout=60)


def test_a_file_that_ends_too_early_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "cut.op2"
    path.write_bytes(BEAM.read_bytes()[:20000])
    with pytest.raises(FormatError, match="is damaged"):
        read_fem(path)


@pytest.mark.parametrize(
    ("content", "said"), [(b"\x08\x00\x00\x00" * 8, "words of eight bytes"), (b"no results", "is no .op2 file")]
)
def test_what_it_cannot_be_is_said(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "other.op2"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=said):
        read_fem(path)


def test_eigenvectors_under_another_name_than_nastrans_are_none(tmp_path: Path) -> None:
    path = tmp_path / "other.op2"
    path.write_bytes(BEAM.read_bytes().replace(b"OUGV1   ", b"OEFX1   "))
    with pytest.raises(DataError, match="no real eigenvectors"):
        read_fem(path)


def test_without_the_package_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path(shutil.copy(BEAM, tmp_path))
    monkeypatch.setattr(nastran_op2, "PACKAGE", "pyyeti_that_is_not_there")
    monkeypatch.setitem(EXTRAS, "pyyeti_that_is_not_there", "nastran")
    with pytest.raises(MissingPackageError, match="needs the package"):
        read_fem(path)
    assert how_to_install("pyyeti") == "pip install 'modallab[nastran]'"

"""Modes of finite-element models: what is read is the cantilever of the closed form, at unit modal mass."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from beam_elements import bdf, beam, closed_form, f06, frd, modes, pch, written
from scipy import io, sparse

from modallab.core.errors import DataError, FormatError
from modallab.formats.fem.fem_file import is_fem, read_fem

EI, PER_M, LENGTH, ELEMENTS = 70.0, 0.8, 0.9, 12
K, M, FREEDOMS, NODES = beam(EI, PER_M, LENGTH, ELEMENTS)
SQUARES, DEFLECTIONS = modes(K, M, 3)
TIP = 2 / np.sqrt(PER_M * LENGTH)
"""Every cantilever's mode is twice its rms at the tip."""


def check(path: Path, places: bool = True) -> None:
    found = read_fem(path).modes
    np.testing.assert_allclose(found.frequency_hz[:3], closed_form(EI, PER_M, LENGTH), rtol=2e-4)
    np.testing.assert_allclose(np.abs(found.at[ELEMENTS][:3, 2]), TIP, rtol=2e-3)
    assert np.all(found.at[3][:3, :2] == 0)
    assert bool(found.places_m) == places
    if places:
        assert found.places_m[ELEMENTS] == pytest.approx((LENGTH, 0.0, 0.0), abs=1e-4)


def test_results_of_calculix_are_read_and_its_static_step_is_no_mode(tmp_path: Path) -> None:
    check(written(tmp_path, "beam.frd", frd(NODES, SQUARES, DEFLECTIONS)))


def test_what_nastran_punches_is_read_with_the_grid_points_beside_it(tmp_path: Path) -> None:
    path = written(tmp_path, "beam.pch", pch(NODES, SQUARES, DEFLECTIONS))
    check(path, places=False)
    written(tmp_path, "beam.bdf", bdf(NODES))
    check(path)


def test_what_nastran_prints_is_scaled_by_the_modal_mass_it_states(tmp_path: Path) -> None:
    check(written(tmp_path, "beam.f06", f06(NODES, SQUARES, DEFLECTIONS, 0.25)), places=False)


def test_numbers_without_the_letter_of_their_exponent_are_read(tmp_path: Path) -> None:
    written(tmp_path, "beam.bdf", "GRID    1               2.5-1   -1.+0   7.D+1\n")
    path = written(tmp_path, "beam.pch", pch(np.array([[1, 0, 0, 0]]), SQUARES[:1], DEFLECTIONS[:1, :1]))
    assert read_fem(path).modes.places_m == {1: (0.25, -1.0, 70.0)}


def test_matrices_of_numpy_and_both_matlabs_are_read(tmp_path: Path) -> None:
    held = {"K": K, "M": M, "dof": FREEDOMS, "nodes": NODES}
    np.savez(tmp_path / "beam.npz", **held)
    io.savemat(tmp_path / "beam5.mat", held | {"K": sparse.csc_matrix(K)})
    with h5py.File(tmp_path / "beam73.mat", "w", userblock_size=512) as target:
        for name in ("M", "dof", "nodes"):
            target[name] = held[name].T
        columns = sparse.csc_array(K)
        group = target.create_group("K")
        group.attrs["MATLAB_sparse"] = np.uint64(K.shape[0])
        group["data"], group["ir"], group["jc"] = columns.data, columns.indices, columns.indptr
    with (tmp_path / "beam73.mat").open("r+b") as target:
        target.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    for name in ("beam.npz", "beam5.mat", "beam73.mat"):
        assert is_fem(tmp_path / name)
        check(tmp_path / name)


def described(folder: Path, text: str) -> Path:
    io.mmwrite(folder / "K.mtx", sparse.coo_matrix(K), symmetry="symmetric")
    sparse.save_npz(folder / "M.npz", sparse.csr_matrix(np.tril(M)))
    rows = [f"{node},{'xyz'[d - 1] if d < 4 else 'r' + 'xyz'[d - 4]}" for node, d in FREEDOMS]
    written(folder, "freedoms.csv", "# node, direction\n" + "\n".join(rows))
    np.savetxt(folder / "nodes.txt", NODES)
    return written(folder, "model.yaml", text)


MATRICES = "stiffness: K.mtx\nmass: M.npz\nfreedoms: freedoms.csv\nnodes: nodes.txt\n"


def test_a_description_names_matrices_of_which_one_triangle_is_written(tmp_path: Path) -> None:
    check(described(tmp_path, MATRICES))


def test_millimetres_and_tonnes_become_metres_and_kilograms(tmp_path: Path) -> None:
    k, m, freedoms, nodes = beam(EI * 1e6, PER_M * 1e-6, LENGTH * 1e3, ELEMENTS)
    np.savez(tmp_path / "beam.npz", K=k, M=m, freedoms=freedoms, nodes=nodes)
    text = "stiffness: beam.npz\nmass: beam.npz\nfreedoms: beam.npz\nnodes: beam.npz\nunits: mm\ndamping_ratio: 0.004\n"
    path = written(tmp_path, "model.yaml", text)
    check(path)
    np.testing.assert_array_equal(read_fem(path).modes.damping_ratio, 0.004)


def test_a_large_sparse_model_has_the_same_modes(tmp_path: Path) -> None:
    k, m, freedoms, nodes = beam(EI, PER_M, LENGTH, 450)
    np.savez(tmp_path / "beam.npz", K=k, M=m, freedoms=freedoms, nodes=nodes)
    found = read_fem(tmp_path / "beam.npz").modes
    np.testing.assert_allclose(found.frequency_hz[:3], closed_form(EI, PER_M, LENGTH), rtol=1e-4)
    np.testing.assert_allclose(np.abs(found.at[450][:3, 2]), TIP, rtol=1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (MATRICES + "results: beam.frd\n", "neither or both of results and matrices"),
        ("stiffness: K.mtx\nmass: M.npz\n", "need stiffness, mass and freedoms"),
        (MATRICES + "unit: mm\n", "unit is no field of a model"),
        (MATRICES.replace("K.mtx", "none.mtx"), "holds no matrices"),
        (MATRICES.replace("freedoms.csv", "nodes.txt"), "2 columns are asked for"),
        ("[", "is no YAML"),
    ],
)
def test_what_a_description_must_not_say_is_named(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises((DataError, FormatError), match=said):
        read_fem(described(tmp_path, text))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda k, m: (k + np.triu(np.full_like(k, 50.0), 1), m), "stiffness matrix is not symmetric"),
        (lambda k, m: (k[:-1, :-1], m), "do not belong together"),
        (lambda k, m: (k, -m), "modes cannot be computed"),
        (lambda k, m: (k * np.nan, m), "zero|NaN"),
    ],
)
def test_matrices_that_are_none_of_a_structure_are_rejected(tmp_path: Path, change, said: str) -> None:
    k, m = change(K, M)
    np.savez(tmp_path / "beam.npz", K=k, M=m, freedoms=FREEDOMS)
    with pytest.raises(DataError, match=said):
        read_fem(tmp_path / "beam.npz")


def test_a_file_without_modes_and_one_cut_off_say_so(tmp_path: Path) -> None:
    text = frd(NODES, SQUARES, DEFLECTIONS)
    with pytest.raises(DataError, match="holds no modes"):
        read_fem(written(tmp_path, "static.frd", text[: text.index("    1PGM")]))
    with pytest.raises(FormatError, match="no whole result file"):
        read_fem(written(tmp_path, "cut.frd", text[: int(0.9 * len(text))]))
    with pytest.raises(DataError, match="no real eigenvectors"):
        read_fem(written(tmp_path, "none.f06", "1    BEAM\n"))
    complex_ones = pch(NODES, SQUARES, DEFLECTIONS).replace("$REAL OUTPUT", "$REAL-IMAGINARY OUTPUT")
    with pytest.raises(DataError, match="no real eigenvectors"):
        read_fem(written(tmp_path, "complex.pch", complex_ones))
    with pytest.raises(FormatError, match="not there"):
        read_fem(tmp_path / "nowhere.frd")

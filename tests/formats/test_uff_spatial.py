"""Structures in space: points, lines and directions go out and come back; local coordinate systems are undone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyuff
from exchange_records import campaign, uff_set, write_uff
from test_import_without_rig import MILLIMETRES, NODES, SHAPE, SQUARE, write

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.exporter import write_export
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.uff.uff_results import read_results
from modallab.formats.uff.uff_shapes import read_uff_shapes

PLACES = {1: (0.0, 0.0, 0.0), 2: (0.5, 0.0, 0.125), 3: (0.5, 0.25, 0.0), 7: (0.0, 0.25, -0.125)}
AXES = ((1, "+z"), (2, "+x"), (2, "-y"), (2, "+z"), (3, "-z"), (7, "+y"))
QUARTER = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
"""Axes turned by 90 degrees about z, a row each."""


def rig() -> Rig:
    force = Channel(index=0, name="force", quantity="force", unit="N", direction="-z", point=3)
    others = [
        Channel(index=k, name=f"p{n}{d}", quantity="acceleration", unit="m/s^2", point=n, direction=d)
        for k, (n, d) in enumerate(AXES, start=1)
    ]
    points = tuple(Point(id=n, x_m=x, y_m=y, z_m=z) for n, (x, y, z) in PLACES.items())
    lines = ((1, 2), (2, 3), (3, 7), (1, 7), (1, 3), (2, 7))
    return Rig(
        name="frame", model="unknown", drive_direction="-z", points=points, lines=lines, channels=(force, *others)
    )


def frf() -> Frf:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(6, 1, 50)) + 1j * rng.normal(size=(6, 1, 50))
    outputs = tuple(c.name for c in rig().responses)
    return Frf(np.arange(1.0, 51), values, "inertance", outputs, tuple(n for n, _ in AXES), (3,))


def model(*, scaled: bool = True) -> ModalModel:
    shapes = np.random.default_rng(2).normal(size=(2, 6)) + 0j
    n = np.full(2, 1e-3)
    return ModalModel(
        method="plscf",
        band_hz=(1.0, 50.0),
        frequency_hz=np.array([10.0, 30.0]),
        damping_ratio=np.array([0.01, 0.02]),
        frequency_sigma_hz=n,
        damping_sigma=n,
        outputs=frf().outputs,
        output_points=frf().output_points,
        input_points=(3,) if scaled else (),
        modal_constants=np.zeros((2, 6, int(scaled))),
        modal_constant_sigma=np.zeros((2, 6, int(scaled))),
        residuals=np.zeros((0, 6, int(scaled))),
        shapes=shapes if scaled else None,
        operating_shapes=None if scaled else shapes,
        half_power=n,
        half_power_floor=n,
    )


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("uff") / "frame.uff"
    write_export(replace(campaign(rig()), blocks=(), frfs=(frf(),)), out, "uff", (model(),))
    return out


def test_points_lines_and_directions_come_back(exported: Path) -> None:
    found, known = draft_rig(exported), rig()
    assert found.points == known.points
    assert set(found.lines) == {(min(a, b), max(a, b)) for a, b in known.lines}
    assert [(c.point, c.direction) for c in found.channels] == [(c.point, c.direction) for c in known.channels]


def test_frfs_come_back_on_either_rig(exported: Path) -> None:
    for on in (rig(), draft_rig(exported)):
        (found,) = import_sources([exported], on).frfs
        np.testing.assert_array_equal(found.values, frf().values)
        assert found.output_points == frf().output_points


def test_shapes_come_back_along_each_direction(exported: Path) -> None:
    (found,) = read_uff_shapes(exported, rig())
    np.testing.assert_allclose(found.shapes, model().shapes, rtol=1e-5)
    np.testing.assert_allclose(found.modal_mass_kg, 1.0, rtol=1e-5)


def test_shapes_without_a_scale_have_no_modal_mass(tmp_path: Path) -> None:
    write_export(replace(campaign(rig()), blocks=(), frfs=(frf(),)), tmp_path / "o.uff", "uff", (model(scaled=False),))
    (found,) = read_uff_shapes(tmp_path / "o.uff", rig())
    assert np.isnan(found.modal_mass_kg).all()


def systems(kind: int = 0, axes: np.ndarray = QUARTER) -> dict:
    matrix = np.vstack([axes, [1000.0, 0.0, 0.0]])
    return {
        "type": 2420, "Part_UID": 1, "Part_Name": "part", "CS_sys_labels": [5], "CS_types": [kind], "CS_colors": [1],
        "CS_names": ["turned"], "CS_matrices": [matrix],
    }  # fmt: skip


def nodes(placed: int, moving: int) -> dict:
    own = {"def_cs": [placed] * 4, "disp_cs": [moving] * 4}
    return NODES | own | {"x": [100.0, 0, 0, 0], "y": [0.0, 200, 0, 0], "z": [0.0, 0, 300, 0]}


def test_nodes_and_motions_in_a_turned_system_are_turned_back(tmp_path: Path) -> None:
    found = read_results(write(tmp_path / "t.uff", MILLIMETRES, systems(), nodes(5, 5), SHAPE | {"r1": [1.0, 0, 0, 0]}))
    np.testing.assert_allclose(
        [found.geometry.points[n] for n in (1, 2, 3)], [(1, 0.1, 0), (0.8, 0, 0), (1, 0, 0.3)], atol=1e-9
    )
    np.testing.assert_allclose(found.modes[0].at[1], [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(found.modes[0].at[2], [0, 0, 1], atol=1e-9)


def test_a_cylindrical_motion_goes_along_the_radius(tmp_path: Path) -> None:
    found = read_results(write(tmp_path / "c.uff", systems(1, np.eye(3)), nodes(0, 5), SHAPE | {"r1": [0.0, 1, 0, 0]}))
    radius = np.array([-1000.0, 200.0]) / np.hypot(1000, 200)
    np.testing.assert_allclose(found.modes[0].at[2], [*radius, 1.0], atol=1e-6)


def test_nodes_placed_by_angles_are_named(tmp_path: Path) -> None:
    path = write(tmp_path / "c.uff", systems(1, np.eye(3)), nodes(5, 0), SHAPE)
    with pytest.raises(DataError, match="node 1 is placed in the cylindrical coordinate system 5"):
        read_results(path)


@pytest.mark.parametrize(("axes", "found"), [(QUARTER, "+y"), (None, None)])
def test_directions_of_channels_are_turned_or_named(tmp_path: Path, axes: np.ndarray | None, found: str | None) -> None:
    half = np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
    head = write(tmp_path / "h.uff", systems(0, half if axes is None else axes), nodes(0, 5))
    one = np.random.default_rng(3).normal(size=64)
    write_uff(tmp_path / "f.uff", uff_set(one, np.arange(64) / 100, 1, rsp_node=2, rsp_dir=1))
    path = tmp_path / "both.uff"
    path.write_bytes(head.read_bytes() + (tmp_path / "f.uff").read_bytes())
    if found is None:
        with pytest.raises(DataError, match=r"direction \+x at node 2 is \[0.8, 0.6, 0.0\]"):
            draft_rig(path)
    else:
        assert draft_rig(path).channels[0].direction == found


def test_a_peer_reads_the_geometry(exported: Path) -> None:
    file = pyuff.UFF(str(exported))
    types = list(file.get_set_types())
    points, trace = file.read_sets(types.index(15)), file.read_sets(types.index(82))
    np.testing.assert_allclose(points["z"], [p.z_m for p in rig().points])
    assert list(trace["nodes"][:5]) == [1, 2, 0, 2, 3]


def test_shells_are_surfaces_and_bars_and_solids_are_lines_alone(tmp_path: Path) -> None:
    """By dataset 2412: label, descriptor, property, material, colour, nodes; a beam has a line more."""
    path = write(tmp_path / "mesh.uff", MILLIMETRES, SQUARE)
    quad = f"{1:10d}{94:10d}{1:10d}{1:10d}{7:10d}{4:10d}\n{1:10d}{2:10d}{3:10d}{4:10d}\n"
    triangle = f"{2:10d}{91:10d}{1:10d}{1:10d}{7:10d}{3:10d}\n{1:10d}{2:10d}{3:10d}\n"
    solid = f"{3:10d}{111:10d}{1:10d}{1:10d}{7:10d}{4:10d}\n{1:10d}{2:10d}{3:10d}{4:10d}\n"
    beam = f"{4:10d}{21:10d}{1:10d}{1:10d}{7:10d}{2:10d}\n{0:10d}{1:10d}{1:10d}\n{2:10d}{4:10d}\n"
    with path.open("a", encoding="ascii") as target:
        target.write(f"    -1\n  2412\n{quad}{triangle}{solid}{beam}    -1\n")
    found = read_results(path).geometry
    assert found.surfaces == ((1, 2, 3, 4), (1, 2, 3))
    assert (2, 4) in found.lines


@pytest.mark.parametrize(("data_type", "turns"), [(2, True), (4, True), (5, False)])
def test_six_numbers_of_a_node_are_what_their_data_type_says(tmp_path: Path, data_type: int, turns: bool) -> None:
    facts = [1, 2, 3 if turns else 2, 8, data_type, 6 if turns else 3]
    numbers = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    words = [f"{1:10d}", "mode 1", f"{1:10d}", *["NONE"] * 5, "".join(f"{v:10d}" for v in facts)]
    whole = ["".join(f"{v:10d}" for v in [0] * 8), f"{0:10d}{0:10d}"]
    reals = ["".join(f"{v:13.5E}" for v in row) for row in ((0, 12.5, 0, 1, 0.01, 0), (0,) * 6, numbers)]
    lines = ["    -1", "  2414", *words, *whole, *reals[:2], f"{7:10d}", reals[2], "    -1"]
    (tmp_path / "x.uff").write_text("\n".join(lines) + "\n")
    (mode,) = read_results(tmp_path / "x.uff").modes
    np.testing.assert_allclose(mode.at[7], numbers[:3] if turns else [0.1 + 0.2j, 0.3 + 0.4j, 0.5 + 0.6j])

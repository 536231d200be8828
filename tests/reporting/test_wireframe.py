"""A structure in space as it is drawn: its lines, its faces, and how both move."""

import json
import re

import numpy as np
from chain import BARE

from modallab.formats.frf_file import rig_without_places
from modallab.modification.mesh import motion_without_scale
from modallab.reporting.figures.wireframe import MovingShape, moving_wireframes, shapes_of_model

CORNERS = {1: (0.0, 0.0, 0.0), 2: (1.0, 0.0, 0.0), 3: (1.0, 1.0, 0.0), 7: (0.0, 1.0, 0.0)}
BENDING = MovingShape("Mode 1", 12.0, np.array([[0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0, 0]], complex))


def test_faces_are_shaded_and_move_with_their_points() -> None:
    drawn = str(moving_wireframes(CORNERS, ((1, 2),), [BENDING], ((1, 2, 3, 7), (1, 2, 99))))
    (faces,) = re.findall(r'data-faces="([^"]*)"', drawn)
    assert json.loads(faces) == [[0, 1, 2, 3]]
    (path,) = re.findall(r'class="faces" d="M([^"]*)Z"', drawn)
    (points,) = re.findall(r'data-points="([^"]*)"', drawn)
    at = np.array(json.loads(points))
    here = np.array([[float(x) for x in place.split()] for place in path.split("L")])
    np.testing.assert_allclose(here, at[:, :2] + at[:, 2:4], atol=0.06)
    assert np.abs(at[1, 2:4]).max() > 1


def test_without_faces_nothing_is_shaded() -> None:
    assert 'class="faces" d=""' in str(moving_wireframes(CORNERS, ((1, 2),), [BENDING]))


def test_a_sensor_across_the_drive_that_reads_against_its_axis_moves_the_other_way() -> None:
    """On the report and on the page alike."""
    model = BARE.model()
    model = model.model_copy(update={"operating_shapes": model.modal_constants[:, :, 0], "shapes": None})
    rig = rig_without_places(model.outputs, (1, 2, 3, 4), (1,), "mobility")

    def drawn(direction: str) -> tuple[np.ndarray, np.ndarray]:
        channels = [c.model_copy(update={"direction": direction} if c.point == 2 else {}) for c in rig.channels]
        turned = rig.model_copy(update={"channels": tuple(channels)})
        report = np.array([shape.motion for shape in shapes_of_model(model, turned)])
        return report, motion_without_scale(model, turned)

    for along, against in zip(drawn("+y"), drawn("-y"), strict=True):
        np.testing.assert_allclose(along[:, 1, 1], -against[:, 1, 1])
        np.testing.assert_allclose(along[:, 0, 2], against[:, 0, 2])
        assert np.abs(along[:, 1, 1]).max() > 0

"""A structure in space as it is drawn: its lines, its faces, and how both move."""

import json
import re

import numpy as np

from modallab.reporting.figures.wireframe import MovingShape, wireframes

CORNERS = {1: (0.0, 0.0, 0.0), 2: (1.0, 0.0, 0.0), 3: (1.0, 1.0, 0.0), 7: (0.0, 1.0, 0.0)}
BENDING = MovingShape("Mode 1", 12.0, np.array([[0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0, 0]], complex))


def test_faces_are_shaded_and_move_with_their_points() -> None:
    drawn = str(wireframes(CORNERS, ((1, 2),), [BENDING], ((1, 2, 3, 7), (1, 2, 99))))
    (faces,) = re.findall(r'data-faces="([^"]*)"', drawn)
    assert json.loads(faces) == [[0, 1, 2, 3]]
    (path,) = re.findall(r'class="faces" d="M([^"]*)Z"', drawn)
    (points,) = re.findall(r'data-points="([^"]*)"', drawn)
    at = np.array(json.loads(points))
    here = np.array([[float(x) for x in place.split()] for place in path.split("L")])
    np.testing.assert_allclose(here, at[:, :2] + at[:, 2:4], atol=0.06)
    assert np.abs(at[1, 2:4]).max() > 1


def test_without_faces_nothing_is_shaded() -> None:
    assert 'class="faces" d=""' in str(wireframes(CORNERS, ((1, 2),), [BENDING]))

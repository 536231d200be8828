"""Where one more hit tells most: at the antinode of the mode that is known least."""

import numpy as np
import pytest

from modallab.core.model import ModalModel
from modallab.core.plan import Precision
from modallab.core.rig import Channel, Point, Rig
from modallab.pipelines.most_informative_point import most_informative_point

PLACES = np.arange(1, 10) / 10
SHAPES = np.array([np.sin(np.pi * PLACES), np.sin(2 * np.pi * PLACES)])
"""(modes, points) of a supported beam: the second has its node at point 5, antinodes at 2 and 3, 7 and 8."""


def rig(axis: str = "z") -> Rig:
    points = tuple(Point(id=n + 1, x_m=x) for n, x in enumerate(PLACES.tolist()))
    force = Channel(index=0, name="force", quantity="force", unit="N")
    sensors = tuple(
        Channel(
            index=n,
            name=f"a{n}",
            quantity="acceleration",
            unit="m/s^2",
            point=n,
            direction="+z" if n == 4 else f"+{axis}",
        )
        for n in range(1, 10)
    )
    return Rig(name="beam", model="unknown", points=points, channels=(force, *sensors))


def model(struck: tuple[int, ...], zeta_sigma: tuple[float, float]) -> ModalModel:
    constants = SHAPES[:, :, None] * SHAPES[:, None, [p - 1 for p in struck]]
    hz, zeta = np.array([10.0, 40.0]), np.array([0.01, 0.01])
    return ModalModel(
        method="plscf", band_hz=(1.0, 60.0), frequency_hz=hz, damping_ratio=zeta, frequency_sigma_hz=1e-6 * hz,
        damping_sigma=zeta * np.array(zeta_sigma), outputs=tuple(f"a{n}" for n in range(1, 10)),
        output_points=tuple(range(1, 10)), input_points=struck, modal_constants=constants.astype(complex),
        modal_constant_sigma=np.full(constants.shape, np.nan), residuals=np.zeros((0, 9, len(struck))),
        half_power=np.full(2, np.nan), half_power_floor=np.full(2, np.nan),
    )  # fmt: skip


@pytest.mark.parametrize(("sigma", "points"), [((0.001, 0.05), {2, 3, 7, 8}), ((0.05, 0.001), {5})])
def test_it_is_an_antinode_of_the_mode_known_least_though_nobody_struck_there(
    sigma: tuple[float, float], points: set[int]
) -> None:
    assert most_informative_point(model((4,), sigma), rig(), {4: 5}, Precision()) in points


def test_the_target_says_which_mode_is_known_least() -> None:
    wide = model((4,), (0.02, 0.01)).model_copy(update={"frequency_sigma_hz": np.array([1e-6, 0.04])})
    assert most_informative_point(wide, rig(), {4: 1}, Precision(frequency_ratio=0.1)) == 5
    assert most_informative_point(wide, rig(), {4: 1}, Precision(frequency_ratio=1e-4)) in {2, 3, 7, 8}


def test_sensors_across_the_drive_say_nothing_of_where_to_strike() -> None:
    """One sensor along the drive at point 4, and points 4 and 5 struck."""
    both = model((4, 5), (0.001, 0.05))
    assert most_informative_point(both, rig("y"), {4: 5, 5: 5}, Precision()) == 4


def test_a_mode_that_no_hit_has_moved_leaves_it_open() -> None:
    assert most_informative_point(model((5,), (0.01, 0.01)), rig("y"), {9: 3}, Precision()) is None

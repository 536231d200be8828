"""What is known of a shape between its points: nothing less at a point, more the farther and the rougher."""

import numpy as np
import pytest

from modallab.core.arrays import Real
from modallab.modification.interpolation import NOISE, SpatialInterpolation

PLACES = np.stack([np.linspace(0.1, 1.0, 10), np.zeros(10), np.zeros(10)], axis=1)
WAVES = np.stack([np.sin(2 * PLACES[:, 0]), np.sin(9 * PLACES[:, 0])], axis=1)


def test_at_the_points_a_shape_is_what_was_measured() -> None:
    between = SpatialInterpolation.of(PLACES, WAVES)
    np.testing.assert_allclose(between.at(PLACES), WAVES, atol=1e-3)
    assert between.uncertainty(PLACES).max() < 3 * NOISE


def test_a_place_differs_from_itself_by_nothing_and_from_others_the_more_the_farther() -> None:
    found = SpatialInterpolation.of(PLACES, WAVES).uncertainty(
        PLACES[4] + np.array([[0, 0, 0], [0.01, 0, 0], [0.05, 0, 0]]), PLACES[4]
    )
    assert np.all(found[0] == 0)
    assert np.all((found[1] > 0) & (found[1] < found[2]))


def test_waves_short_around_a_tube_and_long_along_it_are_known_between_its_points() -> None:
    """Closed form: sin(n phi) around, half a wave along; eight points around, five along, in any position."""
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]

    def tube(angle: Real, along: Real) -> tuple[Real, Real]:
        places = np.stack([along, 0.1 * np.cos(angle), 0.1 * np.sin(angle)], axis=1) @ turn
        shapes = [np.sin(np.pi * (along + 0.1) / 1.2) * np.cos(n * angle - 0.3) for n in (2, 3)]
        return places, np.stack(shapes, axis=1)

    angle, along = (v.ravel() for v in np.meshgrid(np.arange(8) * np.pi / 4, [0.0, 0.25, 0.5, 0.75, 1.0]))
    between = SpatialInterpolation.of(*tube(angle, along))
    places, true = tube(rng.uniform(0, 2 * np.pi, 60), rng.uniform(0, 1, 60))
    error = np.abs(between.at(places) - true)
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < [0.03, 0.25])
    assert 0.2 < np.sqrt(np.mean((error / between.uncertainty(places)) ** 2)) < 2.0


@pytest.mark.parametrize("off", [1e-3, 0.01, 0.1])
def test_how_rough_values_are_is_inferred(off: float) -> None:
    rng = np.random.default_rng(6)
    phase = rng.uniform(0, 2 * np.pi, 200)
    measured = np.sin(4 * PLACES[:, :1] + phase) + off * rng.standard_normal((10, 200))
    between = SpatialInterpolation.of(PLACES, measured)
    places = PLACES[:-1] + np.array([0.05, 0.0, 0.0])
    error = between.at(places) - np.sin(4 * places[:, :1] + phase)
    assert 0.5 < np.sqrt(np.mean((error / between.uncertainty(places)) ** 2)) < 2.0


def test_beyond_the_last_point_it_is_known_least_and_a_rough_shape_less_than_a_smooth_one() -> None:
    within, outside, far = SpatialInterpolation.of(PLACES, WAVES).uncertainty(
        np.array([[0.55, 0, 0], [0.05, 0, 0], [0.0, 0, 0]])
    )
    assert np.all(within < outside)
    assert np.all(outside < far)
    assert np.all(10 * far[:1] < far[1:])


def test_beyond_the_ends_and_between_the_points_the_deviation_is_about_the_error() -> None:
    """Of waves of many lengths and phases, half a step beyond the ends and within."""
    rng = np.random.default_rng(4)
    length, phase = rng.uniform(0.6, 2.5, 200), rng.uniform(0, 2 * np.pi, 200)
    measured = np.sin(2 * np.pi * PLACES[:, :1] / length + phase) + NOISE * rng.standard_normal((10, 200))
    between = SpatialInterpolation.of(PLACES, measured)
    places = np.array([[0.05, 0, 0], [1.05, 0, 0], [0.15, 0, 0], [0.62, 0, 0]])
    error = between.at(places) - np.sin(2 * np.pi * places[:, :1] / length + phase)
    ratio = np.sqrt(np.mean((error / between.uncertainty(places)) ** 2, axis=1))
    assert np.all((ratio > 0.5) & (ratio < 2.0))


def test_of_few_points_much_is_unknown_between_them() -> None:
    """Six points of a plane leave a quadratic surface no freedom: it would be known exactly, and off by its size."""
    rng = np.random.default_rng(2)
    places = np.concatenate([rng.uniform(0, 1, (106, 2)), np.zeros((106, 1))], axis=1)
    shapes = np.sin(3 * places[:, :1] + 1) * np.cos(5 * places[:, 1:2]) * np.array([1.0, -2.0])
    between = SpatialInterpolation.of(places[:6], shapes[:6])
    error = between.at(places[6:]) - shapes[6:]
    assert 0.3 < np.sqrt(np.mean((error / between.uncertainty(places[6:])) ** 2)) < 3.0

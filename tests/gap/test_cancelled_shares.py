"""Shares of a gap that cancel stand together, with what stays of them."""

import numpy as np

from modallab.gap.report.budget import group_cancelling_parts


def shares_of(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    whole = parts.sum(axis=0)
    return parts @ whole / (whole @ whole), parts @ parts.T


def test_two_numbers_that_act_against_each_other_stand_together() -> None:
    parts = np.array([[2.6, 0.1, 0.0], [-1.7, 0.0, 0.1], [0.0, 0.05, 0.0]])
    shares, products = shares_of(parts)
    assert shares[1] < -1
    assert group_cancelling_parts(shares, products) == [[0, 1], [2]]
    assert shares[[0, 1]].sum() > 0.9


def test_numbers_that_act_alike_stay_apart() -> None:
    shares, products = shares_of(np.array([[1.0, 0.0], [0.5, 0.2], [0.0, 0.3]]))
    assert group_cancelling_parts(shares, products) == [[0], [1], [2]]


def test_what_none_of_the_others_takes_up_stays_alone() -> None:
    assert group_cancelling_parts(np.array([-0.5]), np.array([[1.0]])) == [[0]]
    assert group_cancelling_parts(np.array([]), np.zeros((0, 0))) == []

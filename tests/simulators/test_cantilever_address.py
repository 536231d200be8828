"""The address of the simulated bench is read strictly."""

import math

import pytest

from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.address import BenchSettings, parse_address


def test_defaults():
    assert parse_address("sim://cantilever") == BenchSettings()


def test_every_parameter():
    found = parse_address(
        "sim://cantilever?seed=7&bad_hits=0&k_root=inf&pace=1&zeta=0.004,0.005&n_per_v=2&place_m=0.001"
    )
    assert found == BenchSettings(7, 0.0, math.inf, True, (0.004, 0.005), 2.0, 0.001)


def test_unknown_names_are_rejected_with_those_that_are_allowed():
    with pytest.raises(ConfigurationError, match=r"unknown parameter 'sed'[\s\S]*bad_hits.*k_root.*seed"):
        parse_address("sim://cantilever?sed=1")


@pytest.mark.parametrize(
    "query",
    [
        "seed=-1",
        "seed=1.5",
        "seed=",
        "seed",
        "seed=1&seed=1",
        "bad_hits=1.1",
        "bad_hits=nan",
        "k_root=0",
        "k_root=-3",
        "k_root=nan",
        "pace=yes",
        "zeta=0",
        "zeta=0.3",
        "zeta=0.01,,0.02",
        "n_per_v=0",
        "n_per_v=inf",
        "place_m=-0.1",
        "&",
    ],
)
def test_bad_values_are_rejected(query: str):
    with pytest.raises(ConfigurationError):
        parse_address(f"sim://cantilever?{query}")


@pytest.mark.parametrize("url", ["sim://plate", "sim://cantilever/x", "sim://", "sim://cantilever#a", "sim:cantilever"])
def test_other_benches_are_rejected(url: str):
    with pytest.raises(ConfigurationError, match="no simulated bench"):
        parse_address(url)

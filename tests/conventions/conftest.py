"""One campaign of the twin's own, written down in many ways."""

from collections.abc import Callable

import pytest
from twin_campaign import built, link

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return link()


@pytest.fixture(scope="session")
def make(rig: Rig) -> Callable[..., Campaign]:
    """Campaign of a bench with effects."""
    return lambda *effects, **more: built(rig, *effects, **more)


@pytest.fixture(scope="session")
def heavy(make: Callable[..., Campaign]) -> Campaign:
    """A bench with a mass that the rig file does not tell of."""
    return make(Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8}))

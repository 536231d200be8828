"""A small campaign made by the twin itself: cheap, and its truth is known."""

from collections.abc import Callable

import pytest
from twin_campaign import built, link

from modallab.core.block import Campaign
from modallab.core.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return link()


@pytest.fixture(scope="session")
def make(rig: Rig) -> Callable[..., Campaign]:
    return lambda *effects, **more: built(rig, *effects, **more)

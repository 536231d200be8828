"""Whatever the OpenAPI document allows, and much that it does not: no 5xx, no answer that is not documented."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from asked import ask
from furnished import furnish
from lab import Lab

from modallab.core.rig import Rig


@pytest.fixture(scope="module")
def furnished(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    with furnish(tmp_path_factory.mktemp("furnished") / "data", link_rig) as lab:
        yield lab


def test_every_answer_without_a_token_is_as_documented(furnished: Lab, tmp_path: Path) -> None:
    assert ask(furnished, tmp_path, token=None, examples=1, quick=True) == ""


def test_every_answer_with_the_token_is_as_documented(furnished: Lab, tmp_path: Path) -> None:
    assert ask(furnished, tmp_path, examples=2, quick=True) == ""
    assert furnished.controller.state().state in ("idle", "running")

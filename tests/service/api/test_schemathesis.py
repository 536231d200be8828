"""Whatever the OpenAPI document allows, and much that it does not: no 5xx, no answer that is not documented."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from asked import ask
from furnished import furnish
from lab import Lab
from postgresql_server import postgresql_server

from modallab.core.rig import Rig

pytestmark = pytest.mark.thorough("asks the service thousands of questions")


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def furnished(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("furnished") / "data"
    with ExitStack() as stack:
        url = stack.enter_context(postgresql_server()).new_database() if request.param == "postgresql" else None
        yield stack.enter_context(furnish(folder, link_rig, url))


# Who has no token gets no further than to be asked for one, whichever the database.
@pytest.mark.parametrize("furnished", ["sqlite"], indirect=True)
def test_every_answer_without_a_token_is_as_documented(furnished: Lab, tmp_path: Path) -> None:
    # Each is asked with what fits and what does not; the thousands of ways to be wrong come with a token.
    assert ask(furnished, tmp_path, token=None, phases=("examples", "fuzzing"), examples=2) == ""


def test_every_answer_with_the_token_is_as_documented(furnished: Lab, tmp_path: Path) -> None:
    # What is rejected before it comes to a database is asked for with one of them, what chance draws with the other.
    phases = {"sqlite": ("examples", "coverage", "stateful"), "postgresql": ("fuzzing", "stateful")}
    assert ask(furnished, tmp_path, phases=phases[furnished.service.engine.dialect.name], examples=2, quick=True) == ""
    assert furnished.controller.state().state in ("idle", "running")

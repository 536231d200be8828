"""`modallab user`, as an admin types it."""

import re
from pathlib import Path

import pytest

from modallab.cli import main
from modallab.service.records.users import ValidTokens
from modallab.storage import Store


@pytest.fixture
def data(tmp_path: Path) -> str:
    Store(tmp_path / "data").close()
    return str(tmp_path / "data")


def callers(data: str) -> ValidTokens:
    with Store(Path(data)) as store:
        return ValidTokens(store.catalogue.engine, "the service's own")


def test_a_user_is_added_listed_and_revoked(data: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["user", "add", "Ada", "--role", "admin", "--data", data]) == 0
    token = capsys.readouterr().out.splitlines()[-1]
    found = callers(data).of_token(token)
    assert found is not None
    assert (found.name, found.role) == ("Ada", "admin")
    more = ["--role", "observer", "--rig", "link", "--days", "2", "--label", "a screen"]
    assert main(["user", "token", "Ada", *more, "--data", data]) == 0
    second = capsys.readouterr().out.splitlines()[-1]
    assert main(["user", "list", "--data", data]) == 0
    said = capsys.readouterr().out
    assert re.search(r"Ada: admin\n  token \w+: admin\n  token \w+: observer, link, a screen, until 20", said)
    assert token not in said
    assert main(["user", "revoke", "Ada", "--token", token.partition(".")[0], "--data", data]) == 0
    assert callers(data).of_token(token) is None
    assert callers(data).of_token(second) is not None
    assert main(["user", "revoke", "Ada", "--data", data]) == 0
    assert callers(data).of_token(second) is None


def test_what_cannot_be_is_rejected_with_a_sentence(data: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["user", "add", "a/b", "--data", data]) == 2
    assert "name is 'a/b'; allowed" in capsys.readouterr().err
    assert main(["user", "revoke", "Nobody", "--data", data]) == 2
    assert "there is no user 'Nobody'" in capsys.readouterr().err
    assert main(["user", "list", "--data", data + "-not"]) == 2
    assert "is no data folder" in capsys.readouterr().err

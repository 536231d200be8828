"""`modallab backup`, `restore` and `retention`, as an operator types them."""

import shutil
from pathlib import Path

import pytest
from postgresql_server import Server

from modallab.cli import main
from modallab.storage import Store

OLD = Path(__file__).parents[1] / "data" / "store_v1"


@pytest.fixture
def data(tmp_path: Path) -> Path:
    return Path(shutil.copytree(OLD, tmp_path / "data"))


@pytest.mark.thorough("starts a PostgreSQL server")
def test_a_folder_goes_to_a_backup_and_to_a_server(
    data: Path, tmp_path: Path, postgresql: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["backup", str(data), "--out", str(tmp_path / "backup")]) == 0
    url = postgresql.new_database()
    assert main(["restore", str(tmp_path / "backup"), "--out", str(tmp_path / "new"), "--database", url]) == 0
    assert capsys.readouterr().out.count("3 runs, 6 blocks, 0.0 MB of samples: ") == 2
    with Store(tmp_path / "new") as store:
        assert store.catalogue.engine.dialect.name == "postgresql"
        assert len(store.blocks(store.catalogue.runs()[0].id)) == 2
    assert main(["backup", str(data), "--out", str(tmp_path / "backup")]) == 2


def test_retention_lists_first_and_deletes_on_request(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = sorted((data / "runs").glob("*.h5"))
    assert main(["retention", str(data)]) == 0
    said = capsys.readouterr().out
    assert f"{files[2].stem}  aborted, invalid, 0.0 MB" in said
    assert "1 runs, 0.0 MB: deleted only with --delete" in said
    assert sorted((data / "runs").glob("*.h5")) == files
    assert main(["retention", str(data), "--delete"]) == 0
    assert "1 runs, 0.0 MB: deleted" in capsys.readouterr().out
    assert sorted((data / "runs").glob("*.h5")) == files[:2]
    assert main(["retention", str(data), "--state", "done", "--valid", "--older-than", "36500"]) == 0
    assert "0 runs" in capsys.readouterr().out


def test_a_wrong_folder_is_rejected_and_not_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in (
        ["backup", str(tmp_path / "no"), "--out", str(tmp_path / "b")],
        ["retention", str(tmp_path / "no")],
    ):
        assert main(command) == 2
        assert "is no data folder" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []

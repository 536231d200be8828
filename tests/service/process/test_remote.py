"""Settings of other machines: the folder's own word counts, no password is shown, no unsafe scheduler is taken."""

from pathlib import Path

import pytest
from pydantic import SecretStr

from modallab.core.errors import FormatError, JobError
from modallab.core.settings import Settings
from modallab.service.errors import ServiceError
from modallab.service.process.start_up import configure_database, require_scheduler, scheduler_certificates
from modallab.storage import Store
from modallab.storage.engine import database_of

URL = "postgresql+psycopg://modallab:s3cret@db.example:5432/lab"


def _settings(folder: Path, url: str = URL) -> Settings:
    return Settings(data=folder, database=SecretStr(url))


def test_a_new_folder_takes_the_database_of_the_settings_and_keeps_it(tmp_path: Path) -> None:
    configure_database(_settings(tmp_path))
    configure_database(_settings(tmp_path))
    configure_database(Settings(data=tmp_path))
    assert database_of(tmp_path) == URL


def test_another_database_than_the_folders_is_rejected_without_a_password(tmp_path: Path) -> None:
    configure_database(_settings(tmp_path))
    with pytest.raises(ServiceError, match=r"names postgresql.*\*\*\*@db\.example") as rejected:
        configure_database(_settings(tmp_path, URL.replace("lab", "other").replace("s3cret", "hidden")))
    assert "s3cret" not in str(rejected.value)
    assert "hidden" not in str(rejected.value)
    assert database_of(tmp_path) == URL


def test_a_folder_with_its_own_catalogue_is_not_turned_away_from_it(tmp_path: Path) -> None:
    Store(tmp_path).close()
    with pytest.raises(FormatError, match="holds both"):
        configure_database(_settings(tmp_path))
    assert database_of(tmp_path).startswith("sqlite:")


def test_no_password_is_shown_with_the_settings(tmp_path: Path) -> None:
    assert "s3cret" not in repr(_settings(tmp_path))
    assert "s3cret" not in _settings(tmp_path).model_dump_json()
    with pytest.raises(ServiceError, match="is not valid") as rejected:
        configure_database(_settings(tmp_path / "new", "s3cret without a scheme"))
    assert "s3cret" not in str(rejected.value)


def test_the_database_comes_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MODALLAB_DATABASE", URL)
    configure_database(Settings(data=tmp_path))
    assert database_of(tmp_path) == URL


def test_a_scheduler_is_looked_at_before_the_service_begins(tmp_path: Path) -> None:
    files = {name: tmp_path / f"{name}.pem" for name in ("scheduler_ca", "scheduler_cert", "scheduler_key")}
    require_scheduler(Settings())
    require_scheduler(Settings(scheduler="tcp://127.0.0.1:8786"))
    with pytest.raises(JobError, match="neither encryption nor authentication"):
        require_scheduler(Settings(scheduler="tcp://machine:8786"))
    with pytest.raises(JobError, match="needs certificates"):
        require_scheduler(Settings(scheduler="tls://machine:8786"))
    with pytest.raises(ServiceError, match="all of authority, certificate and key"):
        require_scheduler(Settings(scheduler="tls://machine:8786", scheduler_ca=files["scheduler_ca"]))
    complete = Settings(scheduler="tls://machine:8786", **files)
    with pytest.raises(JobError, match="no such certificate file"):
        require_scheduler(complete)
    for file in files.values():
        file.touch()
    tls = scheduler_certificates(complete)
    assert tls is not None
    assert (tls.ca, tls.cert, tls.key) == tuple(files.values())

"""The token: its owner's alone, and no service for others without one that was chosen."""

import stat
import sys
from pathlib import Path

import pytest

from modallab.core.settings import Settings
from modallab.service.errors import ServiceError
from modallab.service.process.start_up import require_token, token_path


def test_a_token_is_made_once_for_its_owner_only(tmp_path: Path) -> None:
    settings = Settings(data=tmp_path / "data")
    token = require_token(settings)
    assert len(token) >= 32
    assert require_token(settings) == token
    if sys.platform != "win32":
        assert stat.S_IMODE(token_path(settings).stat().st_mode) == 0o600
        # One that others could have read is no secret any more.
        token_path(settings).chmod(0o644)
        assert require_token(settings) != token


def test_nobody_else_gets_in_without_a_token_that_was_chosen(tmp_path: Path) -> None:
    with pytest.raises(ServiceError, match=r"other computers can reach 0\.0\.0\.0"):
        require_token(Settings(data=tmp_path, host="0.0.0.0"))
    chosen = "sixteen characters"
    assert require_token(Settings(data=tmp_path, host="0.0.0.0", token=chosen)) == chosen


def test_settings_come_from_the_environment_and_are_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MODALLAB_PORT", "9000")
    monkeypatch.setenv("MODALLAB_HOSTS", '["lab-pc"]')
    assert (Settings().port, Settings().hosts) == (9000, ("lab-pc",))
    monkeypatch.setenv("MODALLAB_TOKEN", "short")
    with pytest.raises(ValueError, match="at least 16 characters"):
        Settings()


def test_the_heartbeat_s_time_out_is_read_under_its_former_name_too(monkeypatch: pytest.MonkeyPatch) -> None:
    renamed = "MODALLAB_SILENCE_S"
    monkeypatch.setenv(renamed, "3")
    assert Settings().heartbeat_timeout_s == 3.0
    monkeypatch.setenv("MODALLAB_HEARTBEAT_TIMEOUT_S", "7")
    assert Settings().heartbeat_timeout_s == 7.0
    assert Settings(heartbeat_timeout_s=5.0).heartbeat_timeout_s == 5.0

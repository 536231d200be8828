"""The service with TLS: a certificate that is made, and what is rejected."""

import os
import ssl
import stat
from datetime import timedelta
from pathlib import Path

import httpx
import pytest
from service_process import ServiceProcess

from modallab.core.settings import Settings
from modallab.service.errors import ServiceError
from modallab.service.process import tls
from modallab.service.process.tls import configure_tls, self_signed


def test_a_certificate_is_made_once_and_anew_for_another_name_or_when_it_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cert, key = self_signed(tmp_path, ("localhost", "10.0.0.5"))
    first = cert.read_bytes()
    assert os.name != "posix" or stat.S_IMODE(key.stat().st_mode) == 0o600
    self_signed(tmp_path, ("localhost",))
    assert cert.read_bytes() == first
    self_signed(tmp_path, ("localhost", "lab-pc"))
    second = cert.read_bytes()
    assert second != first
    monkeypatch.setattr(tls, "LEFT", timedelta(days=900))
    self_signed(tmp_path, ("localhost", "lab-pc"))
    assert cert.read_bytes() != second


def test_what_cannot_be_used_is_rejected_before_anything_starts(tmp_path: Path) -> None:
    cert, key = self_signed(tmp_path / "one", ("localhost",))
    _, other = self_signed(tmp_path / "two", ("localhost",))
    with pytest.raises(ServiceError, match="needs a certificate and its key"):
        configure_tls(Settings(data=tmp_path, tls_cert=cert))
    with pytest.raises(ServiceError, match="and another was requested"):
        configure_tls(Settings(data=tmp_path, tls_cert=cert, tls_key=key, tls_self_signed=True))
    with pytest.raises(ServiceError, match="cannot be used"):
        configure_tls(Settings(data=tmp_path, tls_cert=cert, tls_key=other))
    assert configure_tls(Settings(data=tmp_path)).scheme == "http"


@pytest.mark.thorough("starts one more service, with a certificate")
def test_rest_speaks_tls_and_the_emergency_stop_both(tmp_path: Path) -> None:
    with ServiceProcess(tmp_path / "data", "--no-jobs", "--tls-self-signed") as service:
        assert service.url.startswith("https://")
        trusted = ssl.create_default_context(cafile=tmp_path / "data" / "tls" / "cert.pem")
        with httpx.Client(verify=trusted) as client:
            health = client.get(f"{service.url}/health").json()
            assert health["emergency_stop"] == service.stop_url
            assert service.stop_url.startswith("https://")
            assert client.get(service.stop_url).status_code == 200
            assert client.post(service.stop_url).json()["stopped"] == [service.rig]
            assert client.post(service.stop_url.replace("https", "http")).json()["stopped"] == [service.rig]
        with pytest.raises(httpx.ConnectError):
            httpx.get(f"{service.url}/health")

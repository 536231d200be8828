"""The gRPC route under TLS, with an authority made for the test: who is not who it says is not spoken to."""

from pathlib import Path

import pytest
import trustme
from ni_server import NiServer

from modallab.bench.loader import find_devices, open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest
from modallab.core.errors import ConfigurationError, DeviceGoneError
from modallab.core.rig import Rig

SINE = AcquisitionRequest("sine", 1000.0)


class Authority:
    """Signs certificates for the loopback."""

    def __init__(self) -> None:
        self._ca = trustme.CA()

    def write(self, path: Path) -> Path:
        self._ca.cert_pem.write_to_path(path)
        return path

    def issue(self, folder: Path, name: str) -> tuple[Path, Path]:
        """A certificate and its key."""
        made = self._ca.issue_cert("127.0.0.1")
        paths = folder / f"{name}.crt", folder / f"{name}.key"
        made.cert_chain_pems[0].write_to_path(paths[0])
        made.private_key_pem.write_to_path(paths[1])
        return paths


@pytest.fixture(scope="module")
def authority() -> Authority:
    return Authority()


@pytest.fixture(scope="module")
def folder(authority: Authority, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("tls")
    authority.issue(made, "server")
    authority.write(made / "ca.crt")
    return made


@pytest.fixture(scope="module")
def secure(rig: Rig, folder: Path):
    with NiServer(rig, "9215", "--tls", str(folder)) as server:
        server.say("preamplifiers sine")
        yield server


def test_the_bench_is_driven_and_supervised_over_tls(secure: NiServer, rig: Rig, folder: Path) -> None:
    url = f"{secure.url}&tls={folder / 'ca.crt'}"
    bench = open_bench(url, rig)
    bench.configure(SINE)
    bench.start()
    assert bench.read(100, 5.0).samples.shape == (len(rig.channels), 100)
    handle = open_output(url, rig)
    assert handle is not None
    handle.zero()
    handle.close()
    bench.close()


def test_a_server_another_authority_vouches_for_is_not_spoken_to(secure: NiServer, rig: Rig, tmp_path: Path) -> None:
    other = Authority().write(tmp_path / "other.crt")
    with pytest.raises(DeviceGoneError, match="certificate tls= vouches for"):
        open_bench(f"{secure.url}&tls={other}", rig)


def test_without_tls_a_server_that_has_it_is_not_reached(secure: NiServer, rig: Rig) -> None:
    with pytest.raises(DeviceGoneError, match=r"needs tls=ca\.crt in the address"):
        open_bench(secure.url, rig)


def test_a_server_without_tls_is_not_reached_with_it(ni_server: NiServer, rig: Rig, folder: Path) -> None:
    with pytest.raises(DeviceGoneError):
        open_bench(f"{ni_server.url}&tls={folder / 'ca.crt'}", rig)


def test_a_server_may_want_to_know_who_asks(rig: Rig, folder: Path, authority: Authority, tmp_path: Path) -> None:
    for name in ("server.crt", "server.key"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    authority.write(tmp_path / "clients.crt")
    certificate, key = authority.issue(tmp_path, "operator")
    with NiServer(rig, "9215", "--tls", str(tmp_path)) as server:
        anonymous = f"{server.url}&tls={folder / 'ca.crt'}"
        with pytest.raises(DeviceGoneError):
            open_bench(anonymous, rig)
        bench = open_bench(f"{anonymous}&cert={certificate}&key={key}", rig)
        bench.configure(SINE)
        bench.close()


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("tls=nowhere.crt", "tls: there is no file nowhere.crt"),
        ("tls={ca}&cert={ca}", "only tls, cert is given"),
        ("cert={ca}&key={ca}", "only cert, key is given"),
        ("tsl={ca}", "unknown parameter"),
    ],
)
def test_an_address_with_half_of_what_is_needed_is_rejected(folder: Path, rig: Rig, query: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        open_bench(f"nidaqmx+grpc://127.0.0.1:1/cDAQ1?{query.format(ca=folder / 'ca.crt')}", rig)


def test_devices_are_found_over_tls(secure: NiServer, folder: Path) -> None:
    found = find_devices(f"nidaqmx+grpc://{secure.target}?tls={folder / 'ca.crt'}")
    assert f"nidaqmx+grpc://{secure.target}/cDAQ1?tls={folder / 'ca.crt'}" in [f.address for f in found]

"""The container files, as far as they can be held to their word without an engine that runs containers."""

import json
import os
import re
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import jsonschema_rs
import pytest
import yaml
from kinds_for_tests import kinds
from waiting import ended

from modallab.cli.parser import build_parser
from modallab.jobs import Jobs
from modallab.jobs.cluster import TlsFiles
from modallab.jobs.runner import JobRunner

ROOT = Path(__file__).parents[2]
DOCKER = ROOT / "docker"
PROGRAMS = Path(sys.executable).parent
HERE = str(Path(__file__).parent)
COMMAND = """#!{}
import sys
from modallab.cli import main
if __name__ == "__main__":
    sys.exit(main())
"""


def instructions() -> list[tuple[str, str]]:
    """(instruction, arguments) of the Dockerfile, continued lines joined."""
    text = (DOCKER / "Dockerfile").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    joined = re.sub(r"\\\n\s*", "", "\n".join(lines)).splitlines()
    return [(word, rest) for word, _, rest in (line.partition(" ") for line in joined)]


def of(name: str) -> list[str]:
    return [rest for word, rest in instructions() if word == name]


def compose() -> dict[str, Any]:
    return yaml.safe_load((DOCKER / "compose.yaml").read_text(encoding="utf-8"))


def services() -> dict[str, dict[str, Any]]:
    return compose()["services"]


def test_images_are_official_of_a_fixed_version_and_name_no_registry() -> None:
    images = [rest.split()[0] for rest in of("FROM")]
    images += [service["image"] for service in services().values() if service["image"] != "modallab"]
    assert images
    for image in images:
        assert re.fullmatch(r"[a-z]+:\d[\w.-]*", image), image
    pinned = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'requires-python = ">={images[0].partition(":")[2].partition("-")[0]}"' in pinned


def test_the_image_runs_as_nobody_in_particular_and_says_how_it_is() -> None:
    words = [word for word, _ in instructions()]
    last = words[len(words) - words[::-1].index("FROM") :]
    (user,) = of("USER")
    assert re.fullmatch(r"[1-9]\d{3,}:[1-9]\d{3,}", user)
    assert last.index("USER") < last.index("ENTRYPOINT")
    assert "RUN" not in last[last.index("USER") :]
    assert {"HEALTHCHECK", "ENTRYPOINT", "CMD"} <= set(last)
    assert "ADD" not in words
    assert not any(re.search(r"\bsudo\b|curl|wget|https?://(?!127)|TOKEN|PASSWORD", rest) for _, rest in instructions())
    (installed,) = (run for run in of("RUN") if "apt-get" in run)
    assert "--no-install-recommends" in installed
    assert "rm -rf /var/lib/apt/lists" in installed


def test_what_is_copied_is_there_and_is_all_that_the_package_needs() -> None:
    copied = [part for rest in of("COPY") if "--from" not in rest for part in rest.split()[:-1]]
    assert all((ROOT / path).exists() for path in copied)
    hatch = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    packages = re.search(r"^packages = (\[.*\])$", hatch, re.MULTILINE)
    assert packages is not None
    assert {path.split("/")[0] for path in json.loads(packages[1])} <= set(copied)
    assert {"pyproject.toml", "README.md", "LICENSE", "constraints.txt"} <= set(copied)


@pytest.mark.thorough("starts what the containers start")
def test_every_command_is_one_that_the_programs_know() -> None:
    (command,) = of("CMD")
    commands = [json.loads(command), *(s["command"] for s in services().values() if "command" in s)]
    seen: set[str] = set()
    for program, *rest in commands:
        seen.add(Path(program).name)
        if program == "modallab":
            build_parser("0").parse_args(rest)
        elif program == "dask":
            said = subprocess.run([PROGRAMS / "dask", rest[0], "--help"], capture_output=True, text=True, check=True)
            options = [part for part in rest if part.startswith("--")]
            assert all(re.search(rf"{option}\b", said.stdout) for option in options), options
    assert seen == {"modallab", "dask", "certificates.sh"}


def test_only_this_machine_reaches_the_service_and_nothing_secret_stands_in_the_file() -> None:
    published = [port for service in services().values() for port in service.get("ports", ())]
    assert published
    assert all(port.startswith("127.0.0.1:") for port in published)
    assert compose()["secrets"] == {name: {"file": f"secrets/{name}"} for name in ("database_password", "token")}
    text = (DOCKER / "compose.yaml").read_text(encoding="utf-8")
    assert not re.search(r"://\w+:\w+@|PASSWORD: |TOKEN: ", text)
    for name, service in services().items():
        if service["image"] == "modallab":
            assert service["read_only"] is True, name
            assert service["cap_drop"] == ["ALL"], name


def test_the_file_is_one_by_the_specifications_own_schema() -> None:
    schema = json.loads((ROOT / "tests" / "data" / "compose_spec" / "compose-spec.json").read_text(encoding="utf-8"))
    wrong = list(jsonschema_rs.validator_for(schema).iter_errors(compose()))
    assert wrong == []
    assert not jsonschema_rs.validator_for(schema).is_valid(compose() | {"services": {"service": {"imagine": "x"}}})


def test_the_image_is_built_of_what_it_copies_and_of_nothing_else() -> None:
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    assert lines[1] == "*"
    let_in = {line.removeprefix("!") for line in lines if line.startswith("!")}
    assert let_in == {part for rest in of("COPY") if "--from" not in rest for part in rest.split()[:-1]}


def test_every_part_ends_in_good_order_and_no_secret_needs_a_container_that_can_be_written() -> None:
    for name, service in services().items():
        assert "stop_grace_period" in service, name
        assert service["image"] != "modallab" or service["init"] is True, name


def test_secrets_are_made_once_behind_a_folder_that_is_closed(tmp_path: Path) -> None:
    shutil.copy(DOCKER / "prepare.sh", tmp_path)
    made: list[dict[str, str]] = []
    for _ in range(2):
        subprocess.run(["sh", tmp_path / "prepare.sh"], check=True)
        made.append({path.name: path.read_text() for path in (tmp_path / "secrets").iterdir()})
    assert made[0] == made[1]
    assert set(made[0]) == set(compose()["secrets"])
    assert all(len(text.strip()) >= 16 for text in made[0].values())
    assert stat.S_IMODE((tmp_path / "secrets").stat().st_mode) == 0o700


def as_its_user() -> dict[str, int]:
    """The image's user, where we may become it and it may run our Python."""
    (user,) = of("USER")
    number, group = (int(part) for part in user.split(":"))
    who = {"user": number, "group": group}
    try:
        done = subprocess.run([sys.executable, "-c", "import modallab"], cwd="/", check=False, **who)
    except PermissionError:
        return {}
    return who if done.returncode == 0 else {}


@pytest.fixture
def place() -> Iterator[Path]:
    """A folder of the image's user; pytest's own let nobody else in."""
    folder = Path(tempfile.mkdtemp(prefix="modallab-image-"))
    who = as_its_user()
    if who:
        os.chown(folder, who["user"], who["group"])
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.thorough("starts what the containers start")
def test_the_images_own_command_begins_outside_an_engine_with_the_secret_token(place: Path) -> None:
    """Entry, command, environment and user of the image and of compose; other ports, no database and no cluster."""
    (command,) = of("CMD")
    shutil.copy(DOCKER / "entry.sh", place)
    # The command as it was installed may be for its owner only.
    program = place / "modallab"
    program.write_text(COMMAND.format(sys.executable), encoding="utf-8")
    program.chmod(0o755)
    (place / "token").write_text("a token as secret\n", encoding="ascii")
    own = {"MODALLAB_DATA": str(place / "data"), "MODALLAB_TOKEN_FILE": str(place / "token")}
    own |= {"PATH": f"{place}:{os.environ['PATH']}", "HOME": str(place), "PYTHONUNBUFFERED": "1"}
    own["MODALLAB_HOSTS"] = services()["service"]["environment"]["MODALLAB_HOSTS"]
    arguments = [*json.loads(command), "--port", "0", "--stop-port", "0", "--no-jobs"]
    with subprocess.Popen(
        ["sh", place / "entry.sh", *arguments], env=own, cwd=place, stdout=subprocess.PIPE, text=True, **as_its_user()
    ) as process:
        assert process.stdout is not None
        said = process.stdout.readline()
        found = re.search(r"http://0\.0\.0\.0:(\d+)/", said)
        assert found is not None, said
        url = f"http://127.0.0.1:{found[1]}"
        headers = {"Authorization": "Bearer a token as secret"}
        rigs = httpx.get(f"{url}/api/v1/rigs", headers=headers, timeout=120.0)
        assert rigs.status_code == 200
        assert httpx.get(f"{url}/health", timeout=60.0).status_code == 200
        process.terminate()
        assert process.wait(30) == 0


def test_services_wait_for_what_they_need_and_every_volume_is_declared() -> None:
    found = services()
    for name, service in found.items():
        for other, how in service.get("depends_on", {}).items():
            needed = how["condition"]
            health = found[other].get("healthcheck", {})
            assert (needed == "service_completed_successfully") == (found[other].get("restart") == "no"), name
            assert needed != "service_healthy" or "test" in health, (name, other)
        for volume in service.get("volumes", ()):
            assert volume.split(":")[0] in compose()["volumes"], volume


def test_the_entry_names_the_database_to_the_data_folder_without_its_password(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("s3cret\n")
    environment = os.environ | {
        "MODALLAB_DATA": str(tmp_path),
        "DATABASE_URL": services()["service"]["environment"]["DATABASE_URL"],
        "DATABASE_PASSWORD_FILE": str(tmp_path / "secret"),
    }
    command = ["sh", DOCKER / "entry.sh", "sh", "-c", 'printf %s "$PGPASSWORD"']
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "s3cret"
    address = tmp_path / "database.url"
    assert address.read_text() == "postgresql+psycopg://modallab@database/modallab\n"
    assert stat.S_IMODE(address.stat().st_mode) == 0o600
    plain = {key: value for key, value in os.environ.items() if not key.startswith("DATABASE")}
    done = subprocess.run(["sh", DOCKER / "entry.sh", "echo", "begun"], env=plain, capture_output=True, check=True)
    assert done.stdout == b"begun\n"


def test_a_certificate_that_ends_soon_is_made_anew(tmp_path: Path) -> None:
    first = _certificates(tmp_path)
    short = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj"]
    short += ["/CN=short", "-days", "20", "-keyout", tmp_path / "key.pem", "-out", tmp_path / "cert.pem"]
    subprocess.run(short, check=True, capture_output=True)
    again = _certificates(tmp_path)
    assert set(again) == {"ca.pem", "cert.pem", "key.pem"}
    assert again["ca.pem"] != first["ca.pem"]
    check = ["openssl", "verify", "-CAfile", tmp_path / "ca.pem", tmp_path / "cert.pem"]
    subprocess.run(check, check=True, capture_output=True)


def test_certificates_are_made_once_and_for_their_owner(tmp_path: Path) -> None:
    first = _certificates(tmp_path)
    assert set(first) == {"ca.pem", "cert.pem", "key.pem"}
    assert _certificates(tmp_path) == first
    assert all(stat.S_IMODE((tmp_path / name).stat().st_mode) == 0o600 for name in first)


@pytest.mark.thorough("starts what the containers start")
def test_the_cluster_of_the_file_computes_a_job_over_tls(
    jobs: Jobs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The commands and the environment of compose, with this machine's folders, name and a free port."""
    _certificates(tmp_path)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    found = services()
    with _processes([_here(found[name], tmp_path, port) for name in ("scheduler", "worker")], tmp_path):
        command, environment = _here(found["service"], tmp_path, port)
        files = (
            environment[f"DASK_DISTRIBUTED__COMM__TLS__{key}"] for key in ("CA_FILE", "CLIENT__CERT", "CLIENT__KEY")
        )
        monkeypatch.setattr(TlsFiles, "configured", classmethod(lambda cls: cls(*map(Path, files))))
        job = jobs.submit("square", {"x": 9}, [])
        with JobRunner(jobs, kinds(tmp_path), command[command.index("--scheduler") + 1]):
            (done,) = ended(jobs, job)
    assert (done.state, done.result["square"]) == ("done", 81)


def test_dasks_environment_names_the_certificates(tmp_path: Path) -> None:
    code = "from modallab.jobs.cluster import TlsFiles; print(TlsFiles.configured())"
    names = {k: v for k, v in services()["service"]["environment"].items() if k.startswith("DASK")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | names, capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert [f"/certificates/{name}.pem" in done.stdout for name in ("ca", "cert", "key")] == [True] * 3


def _certificates(folder: Path) -> dict[str, bytes]:
    assert shutil.which("openssl") is not None, "openssl is missing"
    subprocess.run(["sh", DOCKER / "certificates.sh", folder], check=True, capture_output=True)
    return {path.name: path.read_bytes() for path in folder.glob("*.pem")}


def _here(service: dict[str, Any], folder: Path, port: int) -> tuple[list[str], dict[str, str]]:
    def moved(text: str) -> str:
        text = text.replace("/certificates", str(folder)).replace("scheduler:8786", f"127.0.0.1:{port}")
        return {"8786": str(port), "0.0.0.0": "127.0.0.1", "/tmp": str(folder)}.get(text, text)

    command = [moved(part) for part in service["command"]]
    return command, {key: moved(value) for key, value in service["environment"].items()}


@contextmanager
def _processes(commands: list[tuple[list[str], dict[str, str]]], folder: Path) -> Iterator[None]:
    started: list[subprocess.Popen[bytes]] = []
    try:
        for (program, *rest), environment in commands:
            env = os.environ | environment | {"PYTHONPATH": HERE}
            no_output = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            started.append(subprocess.Popen([PROGRAMS / program, *rest], env=env, cwd=folder, **no_output))
            time.sleep(0.1)
        yield
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(5)

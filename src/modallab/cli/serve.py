"""`modallab serve`: the REST service and the emergency stop, until Ctrl-C."""

import argparse
import signal
import webbrowser
from typing import Any

from pydantic import ValidationError

from modallab.cli.demo import demo_rig
from modallab.core.errors import ConfigurationError, RigError
from modallab.core.field_errors import error_sentences
from modallab.core.rig import Rig
from modallab.core.settings import Settings
from modallab.formats.rig.rig_file import read_rig
from modallab.service.process.start_up import configure_database, require_scheduler, require_token, token_path
from modallab.service.process.supervisor import ServiceSupervisor
from modallab.service.process.tls import certificate_fingerprint, configure_tls
from modallab.service.process.workers import set_up

OPTIONS = (
    "data", "host", "port", "stop_port", "token_file", "tls_cert", "tls_key", "tls_self_signed", "scheduler", "workers",
    "jobs",
)  # fmt: skip


def run(arguments: argparse.Namespace) -> int:
    """Serve until asked to leave."""
    given: dict[str, Any] = {name: getattr(arguments, name) for name in OPTIONS}
    settings = _settings({name: value for name, value in given.items() if value is not None})
    set_up(settings.log_level)
    rigs = [_with_bench(read_rig(path), arguments.bench) for path in arguments.rig or ()] or [_demo(arguments.bench)]
    token = require_token(settings)
    settings = configure_tls(settings)
    configure_database(settings)
    require_scheduler(settings)
    with ServiceSupervisor(settings, rigs, token) as supervisor:
        signal.signal(signal.SIGTERM, lambda _number, _frame: supervisor.request_close())
        place = supervisor.place
        print(f"modallab serves at {settings.scheme}://{place.host}:{place.port}/, the API is at /docs")
        if settings.tls_self_signed and settings.tls_cert is not None:
            print(f"certificate:       {settings.tls_cert}, SHA-256 {certificate_fingerprint(settings.tls_cert)}")
        print(f"emergency stop:    curl -X POST {settings.scheme}://{place.host}:{place.stop_port}/emergency-stop")
        print(f"token:             {'as set' if settings.token else token_path(settings)}")
        if arguments.open:
            _open(f"http://{place.host}:{place.port}{supervisor.login_path()}")
        for state in supervisor.controllers.states():
            print(f"rig:               {state.id} at {state.bench}", flush=True)
        supervisor.wait()
    return 0


def _settings(given: dict[str, Any]) -> Settings:
    try:
        return Settings(**given)
    except ValidationError as error:
        raise ConfigurationError(
            "; ".join(error_sentences(error)),
            remedy="change the option, or the variable MODALLAB_... of the environment",
        ) from error


def _open(address: str) -> None:
    print(f"log in once:       {address}")
    # Where there is no browser, the address is there to be copied.
    webbrowser.open(address)


def _with_bench(rig: Rig, url: str | None) -> tuple[Rig, str]:
    address = url or rig.bench
    if not address:
        raise RigError("names no bench", where=rig.name, remedy="give --bench ADDRESS, or a field bench")
    return rig, address


def _demo(url: str | None) -> tuple[Rig, str]:
    return demo_rig(), url or "sim://cantilever?seed=1"

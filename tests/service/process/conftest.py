"""One service for the tests that only ask it something."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from service_process import ServiceProcess


# Not for the session: a service that nobody asks any more would take a twentieth of a processor from all other tests.
@pytest.fixture(scope="package")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServiceProcess]:
    data: Path = tmp_path_factory.mktemp("serve") / "data"
    with ServiceProcess(data, "--workers", "1") as started:
        yield started

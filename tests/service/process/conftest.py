"""One service for the tests that only ask it something."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from service_process import ServiceProcess


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServiceProcess]:
    data: Path = tmp_path_factory.mktemp("serve") / "data"
    with ServiceProcess(data, "--workers", "1") as started:
        yield started

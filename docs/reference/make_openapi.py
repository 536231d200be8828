"""Writes openapi.json and asyncapi.json from the program; run it after a change to the API.

python docs/reference/make_openapi.py
"""

import json
import tempfile
from pathlib import Path

from modallab.core.settings import Settings
from modallab.service.api.app import create_app
from modallab.service.context import open_service
from modallab.service.records.leases import RigLeases
from modallab.service.rigs.controllers import RigControllers
from modallab.storage import Store

HERE = Path(__file__).parent


def main() -> None:
    """Write them."""
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder)) as store:
        controllers = RigControllers([], RigLeases(store.catalogue.engine, "none"))
        service = open_service(Path(folder), controllers, "none")
        app = create_app(service, Settings(data=Path(folder)), "none")
        documents = {"openapi.json": app.openapi(), "asyncapi.json": app.state.asyncapi()}
        service.close()
    for name, document in documents.items():
        (HERE / name).write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

"""Writes openapi.json, asyncapi.json and problems.md from the program; run it after a change to the API.

python docs/reference/make_openapi.py
"""

import json
import tempfile
from pathlib import Path

from modallab.core.settings import Settings
from modallab.service.api.app import create_app
from modallab.service.api.problems import kinds
from modallab.service.context import open_service
from modallab.service.records.leases import Leases
from modallab.service.rigs.controllers import Controllers
from modallab.storage import Store

HERE = Path(__file__).parent

PROBLEMS = """# Problems

What the service rejects, it answers with `application/problem+json` (RFC 9457): `type` is the address of the kind's
page on the service itself, `code` the kind for programs, `detail` what was wrong with its value, `remedy` what to do.
`code` may be more exact than the kind: every code of [the errors](errors.md) can occur, under the kind of the nearest
one in this list. `legal` lists the states that may follow where a run cannot do something now; `errors` names each
field of a request that is not valid.

| code | status | title | meaning |
|---|---|---|---|
"""


def main() -> None:
    """Write them."""
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder)) as store:
        controllers = Controllers([], Leases(store.catalogue.engine, "none"))
        service = open_service(Path(folder), controllers, "none")
        app = create_app(service, Settings(data=Path(folder)), "none")
        documents = {"openapi.json": app.openapi(), "asyncapi.json": app.state.asyncapi()}
        service.close()
    for name, document in documents.items():
        (HERE / name).write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    rows = [f"| `{kind.code}` | {kind.status} | {kind.title} | {kind.meaning} |" for kind in kinds().values()]
    (HERE / "problems.md").write_text(PROBLEMS + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

"""Asks a service all that its OpenAPI document allows, and much that it does not: schemathesis, as a command."""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from lab import RIG, TOKEN, Lab

from modallab.service.records.run_queue import RunQueue
from modallab.service.records.users import UserTable

PHASES = ("examples", "coverage", "fuzzing", "stateful")
CONFIG = """
continue-on-failure = true
max-stream-events = 1
request-timeout = 60

# All checks but two: what the document allows may still be rejected (a plan the bench cannot do); all have one token.
# They are switched off here, since what the command line switches on overrules the operations below.
[checks]
positive_data_acceptance.enabled = false
object_level_authorization.enabled = false

[checks.negative_data_rejection]
# Besides what is common: an ETag, and a body, may be rejected before anyone looks into it.
expected-statuses = [401, 403, 404, 405, 409, 412, 413, 415, 422, 428]

[[operations]]
include-path = "/api/v1/events/stream"
# It has no end: the first event will do, and where none is of the kind asked for, a while of waiting.
request-timeout = 1
parameters = { "query.after" = 0 }

[[operations]]
include-path-regex = "/api/v1/(users/[{]user[}]|campaigns/[{]campaign[}]|runs/[{]run[}]).*"
# Whom no token counts for any more stays in the record of what was done: revoked, and there. What is deleted with a
# grace time is read, and restored, until it ends.
checks.use_after_free.enabled = false
"""

QUICK = """
[[operations]]
include-name = "POST /api/v1/campaigns/{campaign}/runs"
# A plan has so many fields that this phase asks for one run in every fourth of its requests.
phases.coverage.enabled = false

[[operations]]
include-path = "/api/v1/events/stream"
# Three in four of its questions are of names that nothing has, each a second of waiting for an event that never comes.
# The list of events takes the same names, and is asked; the other phases ask for the stream.
phases.coverage.enabled = false
"""


def ask(
    lab: Lab,
    folder: Path,
    *,
    token: str | None = TOKEN,
    phases: Sequence[str] = PHASES,
    examples: int = 5,
    seed: int = 1,
    quick: bool = False,
    options: Sequence[str] = (),
) -> str:
    """What schemathesis found wrong; "" if nothing. Its files are left in `folder`.

    With a token, most requests name things that are there, under the rig's lease.
    """
    known = "" if token is None else _known(lab)
    (folder / "schemathesis.toml").write_text(CONFIG + (QUICK if quick else "") + known, encoding="utf-8")
    (folder / "openapi.json").write_text(json.dumps(lab.app.openapi()), encoding="utf-8")
    command = [str(Path(sys.executable).with_name("st")), "run", "openapi.json", "--url", lab.url]
    command += ["--phases", ",".join(phases)]
    command += ["--max-examples", str(examples), "--seed", str(seed), *options]
    command += [] if token is None else ["--header", f"Authorization: Bearer {token}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, encoding="utf-8")
    said = done.stdout + done.stderr
    (folder / "said.txt").write_text(said, encoding="utf-8")
    return "" if done.returncode == 0 else said


def _known(lab: Lab) -> str:
    service, users = lab.service, UserTable(lab.service.engine)
    runs = [run for campaign in service.repository.campaigns(None, 50) for run in campaign.runs]
    names = {
        "campaign": [campaign.id for campaign in service.repository.campaigns(None, 50)],
        "run": runs,
        "job": [job.id for job in service.jobs.list().jobs],
        "rig": [RIG],
        "n": [block.n for block in service.store.catalogue.blocks(runs[0])],
        "name": ["report.html", "models.json"],
        "item": [item.id for item in RunQueue(service.engine).open(RIG)],
        "user": [user.name for user in users.all_users()],
        "token": [token.id for user in users.all_users() for token in users.tokens(user.name)],
    }
    bound = {f"path.{name}": name for name in names} | {"header.Modallab-Lease": "lease"}
    names["lease"] = [lab.lease().id]
    lines = [f"[dictionaries.{name}]\nvalues = {json.dumps(values)}" for name, values in names.items()]
    lines.append("[parameters]")
    lines += [f'"{place}" = {{ dictionary = "{name}", probability = 0.8 }}' for place, name in bound.items()]
    return "\n".join(lines) + "\n"

"""All phases of schemathesis over the service, with and without its token, longer than the tests do.

The service has campaigns, a run with its model, one that an example began, and jobs; a rig's process is behind it.

    python benchmarks/schemathesis_all.py --max-examples 50 --database postgresql
"""

import argparse
import re
import sys
import tempfile
from contextlib import ExitStack
from importlib.resources import files
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from asked import ask
from furnished import furnish
from lab import TOKEN, Lab
from postgresql_server import postgresql_server

from modallab.formats.rig.rig_file import parse_rig


def ask_all(lab: Lab, folder: Path, token: str | None, examples: int, seed: int) -> bool:
    """Whether every answer was as documented; says how many there were."""
    folder.mkdir(parents=True)
    wrong = ask(lab, folder, token=token, examples=examples, seed=seed)
    cases = re.search(r"\d+ generated[^\n]*", (folder / "said.txt").read_text(encoding="utf-8"))
    name = "without a token" if token is None else "with the token"
    print(f"{name}: {cases[0] if cases else 'no case'}, {'as documented' if not wrong else 'not as documented'}")
    if wrong:
        print(wrong)
    return not wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--max-examples", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--database", choices=["sqlite", "postgresql"], default="sqlite")
    arguments = parser.parse_args()
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    with ExitStack() as stack:
        name = stack.enter_context(tempfile.TemporaryDirectory())
        postgresql = arguments.database == "postgresql"
        url = stack.enter_context(postgresql_server()).new_database() if postgresql else None
        lab = stack.enter_context(furnish(Path(name) / "data", rig, url))
        good = [
            ask_all(lab, Path(name) / part, token, arguments.max_examples, arguments.seed)
            for part, token in (("without", None), ("with", TOKEN))
        ]
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())

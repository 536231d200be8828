"""What is installed is pinned, from whatever index."""

import re
import tomllib
from collections import deque
from importlib.metadata import requires
from itertools import chain
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]


def _pins() -> dict[str, Version]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    return {canonicalize_name(name): Version(version) for name, version in (line.split("==") for line in lines)}


def _direct() -> list[Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    listed = chain(project["dependencies"], *project["optional-dependencies"].values())
    return [need for text in listed if (need := Requirement(text)).name != project["name"]]


def test_every_pin_is_of_one_version_and_names_no_index() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)


def test_every_dependency_is_pinned_and_what_it_needs_too() -> None:
    pins = _pins()
    waiting = deque((need.name, need.extras) for need in _direct())
    seen: set[str] = set()
    while waiting:
        name, extras = waiting.popleft()
        name = canonicalize_name(name)
        assert name in pins, name
        if name in seen:
            continue
        seen.add(name)
        for need in map(Requirement, requires(name) or ()):
            environments = [{"extra": extra} for extra in ("", *extras)]
            if need.marker is None or any(need.marker.evaluate(e) for e in environments):
                waiting.append((need.name, need.extras))


def test_the_pins_fit_what_the_project_asks_for() -> None:
    pins = _pins()
    assert all(pins[canonicalize_name(need.name)] in need.specifier for need in _direct())


def test_every_dependency_has_its_reason_and_licence() -> None:
    text = (ROOT / "docs/decisions/0007-dependencies.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in text.splitlines() if line.startswith("|")]
    named = {canonicalize_name(name.strip()) for row in rows for name in row[1].split(",")}
    assert {canonicalize_name(need.name) for need in _direct()} <= named
    assert all(row[2].strip() and row[3].strip() for row in rows)

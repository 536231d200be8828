"""The page on adding a read-only resource, walked: its two files, away from the package, are all that it takes."""

import re
import sys
from collections.abc import Iterator
from importlib import import_module, invalidate_caches
from pathlib import Path

import pytest
from lab import RIG, TOKEN, Lab

from modallab.core.rig import Rig

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "add-a-resource.md"
FILE = re.compile(r"```py\n# src/(modallab/\S+)/(\w+)\.py\n(.*?)```", re.DOTALL)


@pytest.fixture
def lab_with_the_page(tmp_path: Path, link_rig: Rig, monkeypatch: pytest.MonkeyPatch) -> Iterator[Lab]:
    """A service whose packages have one more folder each, with the page's files."""
    files = FILE.findall(PAGE.read_text(encoding="utf-8"))
    assert len(files) == 2
    added = [f"{place.replace('/', '.')}.{name}" for place, name, _ in files]
    for place, name, text in files:
        folder = tmp_path / place
        folder.mkdir(parents=True)
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
        package = import_module(place.replace("/", "."))
        monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    invalidate_caches()
    try:
        with Lab(tmp_path / "data", link_rig, "sim://cantilever?seed=1") as lab:
            yield lab
    finally:
        for module in added:
            sys.modules.pop(module, None)
            package, _, name = module.rpartition(".")
            monkeypatch.delattr(import_module(package), name, raising=False)


@pytest.mark.thorough("starts the service once more")
def test_two_files_are_a_resource(lab_with_the_page: Lab, link_rig: Rig) -> None:
    path = f"/api/v1/rigs/{RIG}/channels"
    with lab_with_the_page.client() as client:
        answer = client.get(path)
        assert answer.status_code == 200
        assert [item["name"] for item in answer.json()["items"]] == [channel.name for channel in link_rig.channels]
        missing = client.get("/api/v1/rigs/none/channels")
        assert (missing.status_code, missing.json()["code"]) == (404, "not-found")
    with lab_with_the_page.client(token=None) as stranger:
        assert stranger.get(path).status_code == 401
        assert stranger.get(path, headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200
    document = lab_with_the_page.app.openapi()
    answers = document["paths"]["/api/v1/rigs/{rig}/channels"]["get"]["responses"]
    assert {"200", "401", "404", "503"} <= answers.keys()
    assert "ChannelView" in document["components"]["schemas"]


@pytest.mark.thorough("starts the service once more")
def test_without_them_there_is_no_such_resource(lab: Lab) -> None:
    assert "/api/v1/rigs/{rig}/channels" not in lab.app.openapi()["paths"]
    with lab.client() as client:
        assert client.get(f"/api/v1/rigs/{RIG}/channels").status_code == 404

"""Builds one folder of all pages, references and notebooks, to be read without network or server.

    python docs/site.py FOLDER

The lists of the index pages are the navigation. Notebooks become pages. Redoc shows the OpenAPI document.
"""

import json
import re
import shutil
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from made import filled

DOCS = Path(__file__).parent
COPIED = (".png", ".svg", ".json", ".ipynb")
CONFIGURATION = """
project, html_title, html_theme = "modallab", "modallab", "furo"
extensions, myst_heading_anchors, root_doc = ["myst_parser"], 5, "index"
html_extra_path, html_copy_source, html_show_copyright = ["extra"], False, False
exclude_patterns = ["extra"]
"""
INDEXES = ("README.md", "decisions/README.md", "history/README.md")
REST = """# REST, field by field

The [OpenAPI document](openapi.json) as a page. What fields cannot say is in [the API](api.md).

<iframe src="rest-frame.html" title="REST" style="width:100%;height:85vh;border:0;background:#fff"></iframe>
"""
FRAME = """<!doctype html><html lang="en"><meta charset="utf-8"><title>REST</title>
<body style="margin:0"><div id="api"></div>
<script src="redoc.js"></script><script>Redoc.init({document}, {{}}, document.getElementById("api"))</script></html>
"""
_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)")
_SECTION = re.compile(r"^## (.+)$", re.MULTILINE)
_FETCHED = re.compile(r"https://cdn[\w./-]+\.svg")
"""The one thing that Redoc would fetch is its mark."""


def build(out: Path) -> None:
    """Build the site into a folder, which is replaced; a link that leads nowhere ends the build."""
    with TemporaryDirectory() as made:
        pages, site = Path(made) / "pages", Path(made) / "site"
        for source in DOCS.rglob("*"):
            if source.suffix in (".md", *COPIED):
                _put(source, pages)
        _put_rest(pages)
        (pages / "conf.py").write_text(CONFIGURATION, encoding="utf-8")
        command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", str(pages), str(site)]
        done = subprocess.run(command, check=False)
        if done.returncode:
            sys.exit(done.returncode)
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(site, out, ignore=shutil.ignore_patterns(".doctrees", ".buildinfo"))


def _put(source: Path, pages: Path) -> None:
    name = source.relative_to(DOCS).as_posix()
    target = pages / _as_page(name)
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.suffix == ".md":
        lists = _toctrees(source) if name in INDEXES else ""
        target.write_text(_mended(source) + lists, encoding="utf-8")
        return
    shutil.copyfile(source, pages / name)
    if source.suffix == ".ipynb":
        target.write_text(_of_notebook(json.loads(source.read_text(encoding="utf-8")), source.name), encoding="utf-8")


def _as_page(path: str) -> str:
    return path.replace("README.md", "index.md").replace(".ipynb", ".md")


def _toctrees(index: Path) -> str:
    """The lists of an index page as what Sphinx makes its navigation of."""
    before, *parts = _SECTION.split(filled(index.read_text(encoding="utf-8")))
    trees: list[str] = []
    for heading, body in [("", before), *zip(parts[::2], parts[1::2], strict=True)]:
        listed = {_as_page(path): title.replace("`", "") for title, path in _LINK.findall(body) if _is_page(path)}
        if heading == "Reference":
            listed["reference/rest.md"] = "REST, field by field"
        lines = "\n".join(f"{title} <{path}>" for path, title in listed.items())
        caption = f":caption: {heading}\n" if heading else ""
        trees.append(f"\n```{{toctree}}\n{caption}:hidden:\n\n{lines}\n```\n" if lines else "")
    return "".join(trees)


def _is_page(path: str) -> bool:
    return path.endswith((".md", ".ipynb")) and "://" not in path


def _mended(source: Path) -> str:
    """With the parts that the program makes. Links to notebooks lead to their pages, others out of the site nowhere."""

    def mended(link: re.Match[str]) -> str:
        text, target = link.groups()
        path, mark, anchor = target.partition("#")
        if "://" in path or not path:
            return link.group()
        inside = (source.parent / path).resolve().is_relative_to(DOCS)
        return f"[{text}]({_as_page(path)}{mark}{anchor})" if inside else text

    return _LINK.sub(mended, filled(source.read_text(encoding="utf-8")))


def _put_rest(pages: Path) -> None:
    """Redoc with the document inside, since a page of a folder may fetch nothing."""
    extra = pages / "extra" / "reference"
    extra.mkdir(parents=True)
    script = (Path(str(files("fastapi_offline"))) / "static" / "redoc.standalone.js").read_text(encoding="utf-8")
    document = (DOCS / "reference/openapi.json").read_text(encoding="utf-8").replace("</", "<\\/")
    (extra / "redoc.js").write_text(_FETCHED.sub("data:,", script), encoding="utf-8")
    (extra / "rest-frame.html").write_text(FRAME.format(document=document), encoding="utf-8")
    (pages / "reference" / "rest.md").write_text(REST, encoding="utf-8")


def _of_notebook(notebook: dict[str, Any], name: str) -> str:
    parts: list[str] = []
    for cell in notebook["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
        else:
            parts += [f"```python\n{source}\n```", *map(_output, cell["outputs"])]
    return "\n\n".join([*parts, f"[This notebook]({name})"]) + "\n"


def _output(output: dict[str, Any]) -> str:
    data: dict[str, Any] = output.get("data", {})
    for kind in ("image/svg+xml", "text/html"):
        if kind in data:
            # A blank line would end the block of HTML.
            return "<div>" + re.sub(r"\n\s*\n", "\n", "".join(data[kind])) + "</div>"
    if "image/png" in data:
        return f'<img alt="figure" src="data:image/png;base64,{"".join(data["image/png"]).strip()}">'
    return "```text\n" + "".join(data.get("text/plain", output.get("text", ""))).rstrip() + "\n```"


if __name__ == "__main__":
    build(Path(sys.argv[1]).resolve())

"""Draws public names and sentences at random, to be read once by somebody who does not know the project.

    python benchmarks/drawn_words.py SEED [--names 40] [--sentences 30]

Names are public classes, functions and methods with the module they stand in. Sentences are those of the pages, of
the REST descriptions, and of messages and help. Who reads says which are understood at first reading.
"""

import argparse
import ast
import json
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SOURCES = [(base, path) for base in ("src", "drivers", "simulators") for path in sorted((ROOT / base).rglob("*.py"))]


def main() -> None:
    """Print what is drawn."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    parser.add_argument("--names", type=int, default=40)
    parser.add_argument("--sentences", type=int, default=30)
    a = parser.parse_args()
    rng = random.Random(a.seed)
    names, sentences = sorted(set(_names())), sorted({*_messages(), *_of_pages(), *_of_rest()})
    print(f"{len(names)} names, {len(sentences)} sentences")
    print(*rng.sample(names, a.names), "", sep="\n")
    for where, text in rng.sample(sentences, a.sentences):
        print(f"- {where} | {text[:400]}")


def _names() -> Iterator[str]:
    for base, path in SOURCES:
        module = ".".join(path.relative_to(ROOT / base).with_suffix("").parts).replace("modallab.", "", 1)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and node.name[0] != "_":
                yield f"{module}: {node.name}{'' if isinstance(node, ast.ClassDef) else '()'}"
                for part in node.body if isinstance(node, ast.ClassDef) else ():
                    if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef) and part.name[0] != "_":
                        yield f"{module}: {node.name}.{part.name}"


def _messages() -> Iterator[tuple[str, str]]:
    for base, path in SOURCES:
        module = ".".join(path.relative_to(ROOT / base).with_suffix("").parts).replace("modallab.", "", 1)
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call):
                named = [k.value for k in call.keywords if k.arg in ("remedy", "help", "what", "words")]
                for text in map(_text, [*call.args, *named]):
                    if len(text.split()) >= 6 and re.match(r"[\w{]", text):
                        yield f"message {module}", text


def _text(node: ast.expr) -> str:
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(v) if isinstance(v, ast.Constant) else f"{{{ast.unparse(v)}}}" for v in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def _of_pages() -> Iterator[tuple[str, str]]:
    pages = [p for p in sorted((ROOT / "docs").rglob("*.md")) if "history" not in p.parts]
    for path in [*pages, ROOT / "README.md"]:
        prose = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        for paragraph in re.split(r"\n\s*\n", prose):
            if not paragraph.lstrip().startswith(("|", "#")):
                for sentence in re.split(r"(?<=[.!?:]) (?=[A-Z`*\[])", re.sub(r"\s+", " ", paragraph)):
                    if len(sentence.split()) >= 5:
                        yield str(path.relative_to(ROOT)), sentence.strip()


def _of_rest() -> Iterator[tuple[str, str]]:
    def walk(part: Any, where: str) -> Iterator[tuple[str, str]]:
        if isinstance(part, dict):
            described = part.get("description")
            if isinstance(described, str):
                yield from ((where, s) for s in re.split(r"(?<=\.) (?=[A-Z])", described) if len(s.split()) >= 5)
            part = list(part.items())
        for name, inner in part if isinstance(part, list) and part and isinstance(part[0], tuple) else ():
            yield from walk(inner, f"{where}/{name}")
        for inner in part if isinstance(part, list) and part and not isinstance(part[0], tuple) else ():
            yield from walk(inner, where)

    yield from walk(json.loads((ROOT / "docs/reference/openapi.json").read_text(encoding="utf-8")), "REST ")


if __name__ == "__main__":
    main()

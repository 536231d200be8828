"""YAML as rig files use it: a tree of text and numbers, where a key stands once in a mapping."""

from collections.abc import Hashable, Mapping
from typing import Any, cast

import yaml

from modallab.core.rig_problem import Problem

_MAX_DEPTH = 12
_MAX_VALUES = 100_000


class Truth:
    """Stands for true or false, which no field of a rig takes, but which would pass for 1 or 0."""

    def __init__(self, value: bool) -> None:
        self.value = value

    def __repr__(self) -> str:
        return str(self.value).lower()


class _Loader(yaml.SafeLoader):
    """Safe loading that notes repeated keys, of which YAML keeps the last without a word."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.repeated: list[Problem] = []

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        lines: dict[str, int] = {}
        for key, _ in node.value:
            name, line = str(key.value), key.start_mark.line + 1
            if name in lines and name != "<<":
                found = f"found twice, in lines {lines[name]} and {line}"
                self.repeated.append(Problem(name, found, "each field once"))
            lines[name] = line
        return super().construct_mapping(node, deep)


def load_yaml(text: str) -> tuple[object, list[Problem]]:
    """The content of a YAML text, and a problem for every key that stands twice in a mapping.

    Raises:
        Exception: of any kind PyYAML has: the text is not YAML, or no tree of reasonable size.
    """
    loader = _Loader(text)
    try:
        return _tree(loader.get_single_data(), _MAX_DEPTH, [_MAX_VALUES]), loader.repeated
    finally:
        loader.dispose()


def _tree(value: object, depth: int, left: list[int]) -> object:
    # Aliases make a YAML text refer to itself, or stand for more values than a memory holds.
    left[0] -= 1
    if depth == 0 or left[0] < 0:
        raise ValueError("nested too deeply, or too large")
    if isinstance(value, Mapping):
        return {key: _tree(v, depth - 1, left) for key, v in cast("Mapping[object, object]", value).items()}
    if isinstance(value, list):
        return [_tree(v, depth - 1, left) for v in cast("list[object]", value)]
    return Truth(value) if isinstance(value, bool) else value

"""Retired words are found where they stand, and nothing else is."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def _tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_words", ROOT / "docs/reference/check_words.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # A frozen dataclass looks its module up by name.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


TOOL = _tool()
RULES = [
    TOOL.Rule(("zork", "zorks"), "hit", names_only=False, allowed=("zork_logs", "--zork")),
    TOOL.Rule(("frob*",), "reject", names_only=False, allowed=("ConnectionFrobbedError",)),
    TOOL.Rule(("lane",), "way", names_only=True, allowed=()),
    TOOL.Rule(("n_gap",), "what it counts", names_only=True, allowed=()),
]


@pytest.mark.parametrize(
    "text",
    [
        "the zork of the day\n",
        "x = zork_count + 1\n",
        "class LastZork: ...\n",
        "ZORKS = 3\n",
        'text = "two zorks"\n',
        "# Frobbing is over.\n",
        "def frob(): ...\n",
        "def of(lane): ...\n",
        "n_gap = 1\n",
        "size_of_n_gap = 1\n",
    ],
)
def test_a_retired_word_is_found(text: str) -> None:
    path = "a.py" if "zork of" not in text else "a.md"
    assert len(TOOL.check(path, text, RULES)) == 1


@pytest.mark.parametrize(
    "text",
    [
        "bezork = zorkish = 1\n",
        "zork_logs = 2\n",
        "except_ = ConnectionFrobbedError\n",
        '"""In a lane, where n gap is a sentence."""\n',
        "gap_n = n = 1\n",
        "airplane = planes = 1\n",
        "def test_the_lane_is_free(): ...\n",
        'renamed = {"zork": "hit"}\n',
        'RENAMED = {\n    "zork": "hit",\n    "frobs": "rejects",\n}\n',
    ],
)
def test_other_words_are_left_alone(text: str) -> None:
    assert TOOL.check("a.py", text, RULES) == []


def test_what_is_found_says_where_and_what_to_say_instead() -> None:
    assert TOOL.check("docs/page.md", "fine\nthe zorks\n", RULES) == ["docs/page.md:2: zorks -> hit"]


def test_names_of_files_and_fields_of_json_count_as_names() -> None:
    assert TOOL.check("tests/test_zork.py", "", RULES) == ["tests/test_zork.py:1: test_zork (in the path) -> hit"]
    assert TOOL.check("a.json", '{"lane": "in a lane"}\n', RULES) == ["a.json:1: lane -> way"]


def test_options_of_other_programs_are_allowed() -> None:
    assert TOOL.check("a.sh", "fetch --zork\n", RULES) == []

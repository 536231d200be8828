"""A rig file is read as it stands, or rejected in one message with all its errors."""

from contextlib import suppress
from pathlib import Path
from typing import Any, get_args

import pytest
import yaml
from exchange_rigs import beam_content, beam_rig
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.errors import RigError, StorageError
from modallab.core.frozen import Frozen
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import dump_rig, parse_rig, read_rig, write_rig
from modallab.formats.rig.rig_yaml import SECTIONS


def rejection(content: object) -> str:
    with pytest.raises(RigError) as caught:
        parse_rig(content if isinstance(content, str) else yaml.safe_dump(content), "rig.yaml")
    return str(caught.value)


def test_the_practice_rigs_read_as_they_stand(practice: Path) -> None:
    files = sorted(practice.glob("*/rig.yaml"))
    assert len(files) >= 100
    assert all(len(read_rig(file).channels) == 11 for file in files[::10])


def test_a_written_rig_reads_back_equal(tmp_path: Path) -> None:
    rig = beam_rig()
    write_rig(rig, tmp_path / "rig.yaml")
    assert read_rig(tmp_path / "rig.yaml") == rig
    assert [file.name for file in tmp_path.iterdir()] == ["rig.yaml"]


def test_writing_into_a_missing_folder_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"cannot be written"):
        write_rig(beam_rig(), tmp_path / "nowhere" / "rig.yaml")


CASES: list[tuple[str, Any, list[str]]] = [
    ("channels.3.unit", "Pa", ["channels[3].unit: found 'Pa'", "m/s^2"]),
    ("channels.3.sensitivity_v_per_unit", 0, ["channels[3].sensitivity_v_per_unit: found 0", "any number but 0"]),
    ("channels.3.sensitivity_v_per_unit", {"impact": 0.0}, ["channels[3].sensitivity_v_per_unit.impact: found 0.0"]),
    ("channels.3.sensitivity_v_per_unit", "high", ["channels[3].sensitivity_v_per_unit: found 'high'", "impact:"]),
    ("channels.3.sensitivity_v_per_unit", {"shock": 1.0}, ["sensitivity_v_per_unit.shock: no such test", "sine"]),
    ("channels.3.sensitivity_v_per_unit", float("nan"), ["sensitivity_v_per_unit: found nan", "a finite number"]),
    ("channels.3.mass_kg", -1, ["channels[3].mass_kg: found -1; allowed: 0 or more"]),
    ("channels.3.mass_kg", True, ["channels[3].mass_kg: found true; allowed: a number"]),
    ("channels.3.serial", 4711, ["channels[3].serial: found 4711; allowed: text, in quotes"]),
    ("channels.3.calibrated_on", "spring", ["channels[3].calibrated_on: found 'spring'; allowed: a date"]),
    ("channels.3.point", 9, ["channels[3].point: found 9; allowed: the id of a point of this rig: 1, 2, 3"]),
    ("channels.3.index", 2, ["channels[3].index: found 2; allowed: 3"]),
    ("channels.3.index", 2.5, ["channels[3].index: found 2.5; allowed: a whole number"]),
    ("channels.3.name", "a01", ["channels[3].name: found 'a01', as in channels[1]"]),
    ("channels.3.quantity", "force", ["channels: quantity: force at channels[0], channels[3]", "exactly one"]),
    ("channels.3.sensitvity", 1, ["channels[3].sensitvity: no such field; allowed: did you mean sensitivity_v_per"]),
    ("channels.3", "a03", ["channels[3]: found 'a03'; allowed: a group of fields"]),
    ("channels", [], ["channels: found []; allowed: at least one entry"]),
    ("points", 3, ["points: found 3; allowed: a list"]),
    ("points.1.id", 1, ["points[1].id: found 1, as in points[0]; allowed: each once"]),
    ("points.1.x_m", -0.1, ["points[1].x_m: found -0.1; allowed: 0 to beam.length_m = 0.887"]),
    ("surfaces", [[1, 2, 99]], ["surfaces[0]: found 99; allowed: three or more ids of points of this rig"]),
    ("points.1.x_m", 2.0, ["points[1].x_m: found 2; allowed: 0 to beam.length_m = 0.887"]),
    ("beam", None, ["beam: missing; allowed: a beam, or model: unknown"]),
    ("beam.length_m", float("inf"), ["beam.length_m: found inf; allowed: a finite number"]),
    ("beam.length_m", "0,887", ["beam.length_m: found '0,887'; allowed: a number, with a decimal point"]),
    ("limits", {"drive_v": 1}, ["limits.slew_v_per_s: missing", "limits.max_burst_s: missing"]),
    ("converter", {"bits": 64}, ["converter.bits: found 64; allowed: 32 or less"]),
    ("shaker_point", 7, ["shaker_point: found 7; allowed: the id of a point"]),
    ("format_version", 3, ["format_version: found 3; allowed: 1 or 2; a newer file needs a newer modallab"]),
    (
        "revisions",
        [
            {
                "effects": [{"effect": "added_mass", "place": {"x": "tip"}}],
                "applied_on": "2026-01-31",
                "before": 2.0,
                "after": 1.0,
            }
        ],
        ["revisions[0].effects[0].place: found {'x': 'tip'}; allowed: x (a share of the length, or all), channel"],
    ),
    ("model", "plate", ["model: found 'plate'; allowed: 'cantilever' or 'unknown'"]),
]


@pytest.mark.parametrize(("place", "value", "lines"), CASES)
def test_each_wrong_field_is_named_with_its_value_and_what_is_allowed(place: str, value: Any, lines: list[str]) -> None:
    content: Any = beam_content()
    target = content
    *path, last = (int(part) if part.isdigit() else part for part in place.split("."))
    for part in path:
        target = target[part]
    target[last] = value
    message = rejection(content)
    assert all(line in message for line in lines), message
    assert "pydantic" not in message


def test_all_errors_stand_in_one_message_even_those_between_fields() -> None:
    content = beam_content()
    content["channels"][1]["mass_kg"] = "heavy"
    content["channels"][2]["unit"] = "Pa"
    content["channels"][3]["name"] = "a01"
    content["points"][2]["x_m"] = 3.0
    content["shaker_point"] = 12
    content["beam"]["lenght_m"] = 1
    message = rejection(content)
    assert message.startswith("rig.yaml: 6 fields are wrong:")
    for field in ("channels[1].mass_kg", "channels[2].unit", "channels[3].name", "points[2].x_m", "shaker_point"):
        assert f"\n  {field}: " in message
    assert "beam.lenght_m: no such field; allowed: did you mean length_m?" in message


def test_a_field_that_is_wrong_on_its_own_is_not_blamed_for_others() -> None:
    content = beam_content()
    content["points"][0]["id"] = "first"
    content["channels"][0]["quantity"] = "push"
    message = rejection(content)
    assert message.startswith("rig.yaml: 2 fields are wrong:")


def test_wrong_channels_of_a_small_rig_still_count_as_channels() -> None:
    channels = [
        {"index": 0, "name": "force", "quantity": "force", "unit": "kg"},
        {"index": 1, "nmae": "tip", "quantity": "acceleration", "unit": "m/s^2", "sensitivity_v_per_unit": 0},
    ]
    reported = rejection({"name": "small", "model": "unknown", "channels": channels})
    for field in ("channels[0].unit", "channels[1].name", "channels[1].nmae", "channels[1].sensitivity_v_per_unit"):
        assert field in reported
    assert "at least 2 entries" not in reported


def test_a_key_that_stands_twice_is_an_error() -> None:
    text = yaml.safe_dump(beam_content()) + "name: another\n"
    assert "name: found twice, in lines" in rejection(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("- 1\n- 2\n", "not fields"),
        ("beam: {length_m: 1\n", "is not YAML: line 2"),
        ("name: a: b", "is not YAML: line 1, column 8"),
        ("name: \x00", "is not YAML"),
        ("a: &a [*a]", "is not YAML: nested too deeply"),
        ("name: !!timestamp x", "is not YAML"),
        ("[" * 1500, "is not YAML: nested too deeply"),
    ],
)
def test_what_is_no_rig_at_all_is_rejected(text: str, words: str) -> None:
    assert words in rejection(text)


def test_missing_file_folder_and_binary_are_named(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_bytes(b"\x89HDF\r\n\xff")
    for path, words in (
        (tmp_path / "no.yaml", "No such file"),
        (tmp_path, "is a folder"),
        (tmp_path / "rig.yaml", "UTF"),
    ):
        with pytest.raises(RigError, match=words) as caught:
            read_rig(path)
        assert str(path) in str(caught.value)


def test_every_part_of_a_rig_suggests_its_own_fields() -> None:
    parts = {
        name: part
        for name, field in Rig.model_fields.items()
        for part in (field.annotation, *get_args(field.annotation))
        if isinstance(part, type) and issubclass(part, Frozen)
    }
    assert parts == {name: part for name, part in SECTIONS.items() if name}


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.data())
def test_a_damaged_rig_file_raises_nothing_but_a_rig_error(data: st.DataObject) -> None:
    text = bytearray(dump_rig(beam_rig()).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        text[data.draw(st.integers(0, len(text) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(text)))
    with suppress(RigError):
        parse_rig(bytes(text[:cut]).decode("utf-8", errors="replace"), "rig.yaml")

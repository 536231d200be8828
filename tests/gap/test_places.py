"""Places keep the form they have in stored documents."""

import pytest
from pydantic import TypeAdapter, ValidationError

from modallab.core.effect import AlongBeam, Place, PlaceOnStructure, place_in_metres, place_relative_to_length
from modallab.core.effects import Effect, catalogue
from modallab.core.field_errors import error_sentences

STORED: list[dict[str, object]] = [
    {},
    {"x": 0.62},
    {"x": 0.62, "x_m": 0.47},
    {"x": "all"},
    {"channel": 3},
    {"channel": 3, "level_v": 0.3},
    {"channel": [3, 7]},
    {"channel": "all"},
    {"where": "base"},
]
ON_STRUCTURE: list[dict[str, object]] = [
    {"point": 3, "at_m": [0.1, 0.2, 0.0]},
    {"point": 3, "at_m": [0.1, 0.2, 0.0], "axis": "z"},
    {"channel": "a2"},
    {"channels": "all"},
]


@pytest.mark.parametrize(
    ("form", "stored"), [*((Place, s) for s in STORED), *((PlaceOnStructure, s) for s in ON_STRUCTURE)]
)
def test_a_stored_place_is_written_as_it_was_read(form: object, stored: dict[str, object]) -> None:
    reader: TypeAdapter[object] = TypeAdapter(form)
    assert reader.dump_python(reader.validate_python(stored), mode="json") == stored


@pytest.mark.parametrize("name", catalogue())
def test_the_fixed_place_of_an_effect_is_read_back(name: str) -> None:
    place = catalogue()[name].fixed_place
    if place is not None:
        effect = Effect(effect=name, place=place)
        assert Effect.model_validate_json(effect.model_dump_json()) == effect


@pytest.mark.parametrize("wrong", [{"x": "tip"}, {"channel": "a2"}, {"point": 3}, {"x": 0.1, "channel": 2}])
def test_what_is_no_place_on_a_beam_raises_one_error(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError) as raised:
        Effect(effect="added_mass", place=wrong)
    (line,) = error_sentences(raised.value)
    assert line.startswith("place is ")
    assert "x (a share of the length, or all)" in line


def test_metres_are_a_reports_and_shares_the_catalogues() -> None:
    place = place_in_metres(AlongBeam(x=0.5), 0.8)
    assert place.model_dump() == {"x": 0.5, "x_m": 0.4}
    assert place_relative_to_length(place) == AlongBeam(x=0.5)

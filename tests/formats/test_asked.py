"""What can be said of a recording can be said wherever one is imported."""

from dataclasses import fields

import pytest

from modallab.cli.parser import build_parser
from modallab.core.errors import DataError
from modallab.formats.asked import ASKED
from modallab.formats.options import ImportOptions, options_of
from modallab.service.api.imports import router

VALUES = {"number": "2.5", "count": "3", "test": "sine", "map": "map.yaml", "text": "x=y"}


def test_every_option_is_described() -> None:
    assert {field.name for field in fields(ImportOptions)} == set(ASKED)


@pytest.mark.parametrize("name", ASKED)
def test_the_command_takes_every_option(name: str) -> None:
    one = ASKED[name]
    flag = "--" + (one.called or name).replace("_", "-")
    values = [] if one.kind == "switch" else [VALUES[one.kind]]
    found = build_parser("0").parse_args(["import", "a.csv", "--out", "a.h5", flag, *values])
    assert getattr(found, one.called or name)


def test_the_service_takes_every_option_of_records() -> None:
    (route,) = (r for r in router.routes if getattr(r, "path", "").endswith("/imports"))
    named = {p.name for p in route.dependant.dependencies[-1].query_params}  # type: ignore[attr-defined]
    assert named == {name for name, one in ASKED.items() if not one.frfs}


def test_an_option_that_there_is_not_is_named_with_the_nearest() -> None:
    with pytest.raises(DataError, match="no option 'chanels'") as caught:
        options_of({"chanels": ("a",)}, 1)
    assert "channels" in caught.value.remedy

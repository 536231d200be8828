"""Shakers beside the first one: which force channel is whose, and what does not go together."""

from importlib import resources
from typing import Any

import pytest
import yaml
from two_shakers import TIP, two_shakers

from modallab.core.errors import RigError
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import dump_rig, parse_rig


@pytest.fixture(scope="module")
def one() -> Rig:
    path = resources.files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@pytest.fixture(scope="module")
def both(one: Rig) -> Rig:
    return two_shakers(one, output="cDAQ1Mod4/ao1")


def test_the_first_shakers_force_channel_is_the_one_that_no_other_names(both: Rig) -> None:
    assert both.force_channel.name == "force"
    assert [c.name for c in both.forces] == ["force", TIP]
    assert both.shaker_points == (4, 9)
    assert all(c.quantity != "force" for c in both.responses)


def test_a_rig_of_one_shaker_does_not_speak_of_others(one: Rig, both: Rig) -> None:
    assert "shakers" not in one.model_dump()
    assert [c.name for c in one.forces] == ["force"]
    assert one.shaker_points == (4,)
    assert parse_rig(dump_rig(both), "two.yaml") == both


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shakers": [{"point": 4, "force": TIP}]}, "shakers[0].point: found 4, which another shaker has"),
        ({"shakers": [{"point": 77, "force": TIP}]}, "shakers[0].point: found 77"),
        ({"shakers": [{"point": 9, "force": "a01"}]}, "shakers[0].force: found 'a01'"),
        ({"shakers": []}, "with an entry under shakers for each further one"),
        (
            {"shakers": [{"point": 9, "force": TIP}, {"point": 7, "force": "force"}]},
            "without a shaker, for the first shaker",
        ),
        ({"shaker_point": None}, "shaker_point: missing"),
        (
            {"excitation": {"output": "ao1"}, "shakers": [{"point": 9, "force": TIP, "output": "ao1"}]},
            "shakers[0].output: found 'ao1', which another shaker has",
        ),
        ({"shakers": [{"point": 9, "froce": TIP}]}, "shakers[0].froce"),
    ],
)
def test_what_does_not_go_together_is_said_with_its_field(both: Rig, change: dict[str, Any], words: str) -> None:
    content = yaml.safe_load(dump_rig(both)) | change
    with pytest.raises(RigError) as caught:
        parse_rig(yaml.safe_dump(content), "two.yaml")
    assert words in str(caught.value)

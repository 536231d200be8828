"""Channels of an openDAQ device as the rig file names them."""

import pytest

from modallab.bench.loader import open_bench
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig

DEVICE = "daqref://device0"


def wired(rig: Rig, inputs: dict[int, str]) -> Rig:
    channels = tuple(c.model_copy(update={"input": inputs.get(c.index, "")}) for c in rig.channels)
    return rig.model_copy(update={"channels": channels})


def test_a_channel_reads_the_input_it_names_and_the_others_the_rest_in_order(rig: Rig):
    bench = open_bench(DEVICE, wired(rig, {0: "RefCh12", 2: "AI0"}))
    facts = [bench.info.facts[f"input of {c.name}"] for c in rig.channels]
    bench.close()
    assert facts[:4] == ["RefCh12", "RefCh1", "RefCh0", "RefCh2"]
    assert len(set(facts)) == len(rig.channels)


def test_an_input_the_device_does_not_have_is_rejected_with_those_it_has(rig: Rig):
    with pytest.raises(ConfigurationError, match=r"channels\[1\].input: found 'Mod1/ai0'.*RefCh0, RefCh1"):
        open_bench(DEVICE, wired(rig, {1: "Mod1/ai0"}))

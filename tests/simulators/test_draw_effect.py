"""Drawn effects open the gap that was requested, in units of the channels' noise."""

from importlib.resources import files
from math import exp

import pytest

from modallab.core.effects import Effect
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab_simulators.cantilever.blind_trials import GAP_RANGE, GapMeter, draw_effect, draw_gap, size_for_gap


@pytest.fixture(scope="module")
def link() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@pytest.fixture(scope="module")
def ruler(link: Rig) -> GapMeter:
    return GapMeter(link, 4)


def gain(value: float) -> tuple[Effect, ...]:
    return (Effect(effect="gain_error", parameters={"gain": value}, place={"channel": 5}),)


def test_nothing_opens_no_gap(ruler: GapMeter):
    assert ruler.gap(()) < 0.01


def test_a_small_effect_of_twice_the_size_opens_twice_the_gap(ruler: GapMeter):
    assert ruler.gap(gain(1.02)) == pytest.approx(2 * ruler.gap(gain(1.01)), rel=1e-3)


def test_noise_of_one_channel_is_counted_without_being_drawn(ruler: GapMeter, link: Rig):
    noisy = Effect(effect="noisy_channel", parameters={"factor": 11.0}, place={"channel": 5})
    converter = link.converter
    assert converter is not None
    share = converter.noise_rms_v**2 / (converter.noise_rms_v**2 + converter.volts_per_count**2 / 12)
    assert ruler.gap((noisy,)) == pytest.approx((120 * share / 10) ** 0.5, rel=1e-3)


@pytest.mark.thorough("draws an effect of a stated gap")
def test_the_requested_gap_is_met(link: Rig, ruler: GapMeter):
    drawn = draw_effect(link, 4, "gain_error", 3.0)
    assert drawn.gap == pytest.approx(3.0, rel=0.05)
    assert ruler.gap((drawn.effect,)) == pytest.approx(drawn.gap, rel=1e-6)


def test_a_size_is_found_where_the_gap_grows_out_of_proportion():
    size, gap = size_for_gap(lambda s: exp(s) + exp(3 * s), (-6.0, 6.0), 1.0, 500.0)
    assert gap == pytest.approx(500.0, rel=0.05)
    assert gap == pytest.approx(exp(size) + exp(3 * size), rel=1e-9)


def test_gaps_are_drawn_evenly_on_logarithms():
    gaps = [draw_gap(seed) for seed in range(400)]
    assert GAP_RANGE[0] <= min(gaps) < 1.6
    assert 280 < max(gaps) <= GAP_RANGE[1]
    assert sum(g < (GAP_RANGE[0] * GAP_RANGE[1]) ** 0.5 for g in gaps) == pytest.approx(200, abs=40)


def test_an_effect_of_no_catalogue_and_of_no_bench_is_rejected(link: Rig):
    with pytest.raises(ConfigurationError, match="no effect is called 'gremlin'"):
        draw_effect(link, 1, "gremlin")

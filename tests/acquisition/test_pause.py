"""Pause, repeat, drop: what may be done to a running test, on a bench whose signals are known."""

from dataclasses import dataclass, field, replace

import pytest
from scripted_bench import ScriptedBench, Strike, scripted_rig

from modallab.acquisition.monitor.run_states import DropBlock, OperatorRequests
from modallab.acquisition.process.run import run_plan
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.runs import RepeatFrequency
from modallab.core.events import Event
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Limits
from modallab.storage import Store

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
RIG = scripted_rig(LIMITS)
IMPACT = ImpactPlan(points=(2, 1), hits=2, block_s=0.256, hit_timeout_s=5.0)
SINE = SinePlan(frequencies_hz=(27.34375, 60.0), levels_v={"low": 0.5}, settle_s=2.0, wait_s=1.0)


@dataclass
class Operator:
    """Does something once, at the first event for which `when` holds, and something else once the run is paused."""

    requests: OperatorRequests
    events: list[Event] = field(default_factory=list)

    def __call__(self, event: Event) -> None:
        self.events.append(event)
        if event.kind == "state" and event.state == "paused":
            self.at_pause()
        else:
            self.look(event)

    def at_pause(self) -> None:
        self.requests.resume()

    def look(self, event: Event) -> None:
        """Nothing."""

    @property
    def states(self) -> list[str]:
        return [e.state for e in self.events if e.kind == "state"]


class Pauses(Operator):
    """Pauses at the first block."""

    def look(self, event: Event) -> None:
        if event.kind == "block" and "paused" not in self.states:
            self.requests.pause()


class RealTime(ScriptedBench):
    """Time goes on by itself."""

    @property
    def info(self) -> BenchInfo:
        return replace(super().info, real_time=True)


def run(bench: ScriptedBench, plan: Plan, store: Store, kind: type[Operator]) -> tuple[Operator, str]:
    requests = OperatorRequests()
    operator = kind(requests)
    with store.begin(plan, RIG, bench.info) as recorder:
        run_plan(bench, RIG, plan, recorder, operator, requests=requests)
    return operator, recorder.run


@pytest.mark.parametrize("plan", [IMPACT, SINE], ids=["impact", "sine"])
@pytest.mark.parametrize("kind", [ScriptedBench, RealTime])
def test_a_run_pauses_at_a_boundary_with_the_output_at_zero_and_goes_on(
    store: Store, plan: Plan, kind: type[ScriptedBench]
) -> None:
    bench = kind()
    operator, name = run(bench, plan, store, Pauses)
    assert operator.states == ["created", "arming", "armed", "acquiring", "paused", "acquiring", "processing", "done"]
    expected = 4 if isinstance(plan, ImpactPlan) else 2
    assert len(store.blocks(name)) == expected
    assert len({b.name for b in store.blocks(name)}) == expected


def test_between_pause_and_going_on_the_output_is_at_zero(store: Store) -> None:
    bench = ScriptedBench()

    class Looks(Pauses):
        def at_pause(self) -> None:
            assert bench.done[-1] == "zero"
            assert not bench.bursts
            self.requests.resume()

    operator, _ = run(bench, SINE, store, Looks)
    assert "paused" in operator.states


def test_while_paused_in_real_time_samples_are_read_and_none_is_lost(store: Store) -> None:
    bench = RealTime()
    before: list[int] = []

    class Waits(Pauses):
        def at_pause(self) -> None:
            before.append(bench.position)

    requests = OperatorRequests()
    operator = Waits(requests)

    def control() -> None:
        if before and bench.position > before[0] + 3000:
            requests.resume()

    with store.begin(SINE, RIG, bench.info) as recorder:
        run_plan(bench, RIG, SINE, recorder, operator, control, requests=requests)
    assert operator.states[-1] == "done"
    rows = store.catalogue.blocks(recorder.run)
    # The next burst waits for its own rest after the pause.
    assert rows[1].note.first_sample > before[0] + 3000
    assert rows[1].note.facts["settled_before"] == "yes"


@pytest.mark.parametrize(("order", "state"), [("stop", "done"), ("abort", "aborted")])
def test_a_paused_run_can_be_ended(store: Store, order: str, state: str) -> None:
    class Stays(Pauses):
        def at_pause(self) -> None:
            """Stay paused."""

    requests, bench = OperatorRequests(), ScriptedBench()
    operator = Stays(requests)
    with store.begin(IMPACT, RIG, bench.info) as recorder:
        run_plan(
            bench, RIG, IMPACT, recorder, operator, lambda: order if operator.states[-1] == "paused" else None,
            requests=requests,
        )  # fmt: skip
    assert operator.states[-3:] == ["paused", "stopping", state]


def test_a_pause_takes_back_the_call_for_a_hit_and_asks_again(store: Store) -> None:
    class AtThePrompt(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "hit_requested" and event.hit == 2 and "paused" not in self.states:
                self.requests.pause()

    bench = ScriptedBench([Strike(delay=4000)])
    operator, name = run(bench, IMPACT, store, AtThePrompt)
    assert len([e for e in operator.events if e.kind == "hit_requested"]) == 5
    assert len(store.blocks(name)) == 4


def test_before_the_first_hit_there_is_nothing_to_pause(store: Store) -> None:
    class Early(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "hit_requested" and len(self.events) < 5:
                self.requests.pause()
            if event.kind == "block":
                self.requests.resume()

    operator, name = run(ScriptedBench(), IMPACT, store, Early)
    assert "paused" not in operator.states
    assert len(store.blocks(name)) == 4


def test_a_dropped_hit_no_longer_counts_and_is_asked_for_again(store: Store) -> None:
    class Drops(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "block" and event.name == "impact_p02_2":
                self.requests.add(DropBlock("impact_p02_1", "the tip was loose"))

    operator, name = run(ScriptedBench(), IMPACT, store, Drops)
    assert [b.name for b in store.blocks(name)] == [
        "impact_p02_2",
        "impact_p02_1_again_1",
        "impact_p01_1",
        "impact_p01_2",
    ]
    (dropped,) = [e for e in operator.events if e.kind == "dropped"]
    assert (dropped.name, dropped.reason) == ("impact_p02_1", "the tip was loose")
    first = store.catalogue.blocks(name)[0]
    assert (first.note.accepted, first.note.reason) == (False, "the tip was loose")
    # Its samples are where they were.
    assert store.blocks(name, rejected=True)[0].n_samples == 512
    progress = [(e.done, e.total) for e in operator.events if e.kind == "progress"]
    assert progress == [(1, 4), (1, 4), (2, 4), (3, 4), (4, 4)]


def test_a_hit_dropped_at_the_very_end_is_left_out(store: Store) -> None:
    class Late(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "progress" and event.done == 4:
                self.requests.add(DropBlock("impact_p01_2"))

    operator, name = run(ScriptedBench(), IMPACT, store, Late)
    assert operator.states[-1] == "done"
    assert [b.name for b in store.blocks(name)] == ["impact_p02_1", "impact_p02_2", "impact_p01_1"]


def test_a_drop_of_what_is_not_there_changes_nothing(store: Store) -> None:
    class Wrong(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "block":
                self.requests.add(DropBlock("impact_p99_9"))
                self.requests.add(RepeatFrequency(frequency_hz=20.0))

    operator, name = run(ScriptedBench(), IMPACT, store, Wrong)
    assert not [e for e in operator.events if e.kind == "dropped"]
    assert len(store.blocks(name)) == 4


def test_a_repeated_frequency_comes_next_and_takes_the_place_of_the_first(store: Store) -> None:
    class Repeats(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "block" and event.name == "sine_low_027.344":
                self.requests.add(RepeatFrequency(frequency_hz=27.344))

    bench = ScriptedBench()
    operator, name = run(bench, SINE, store, Repeats)
    assert bench.done.count("play") == 3
    assert [b.name for b in store.blocks(name)] == ["sine_low_027.344_again_1", "sine_low_060.000"]
    assert [b.frequency_hz for b in store.blocks(name)] == [27.34375, 60.0]
    (dropped,) = [e for e in operator.events if e.kind == "dropped"]
    assert dropped.reason == "repeated as sine_low_027.344_again_1"


def test_until_the_repeat_is_kept_the_first_counts(store: Store) -> None:
    class Repeats(Operator):
        def look(self, event: Event) -> None:
            if event.kind == "progress" and event.done == 2:
                self.requests.add(RepeatFrequency(frequency_hz=60.0))

    # The request comes after the last look: there is no time for it.
    _, name = run(ScriptedBench(), SINE, store, Repeats)
    assert [b.name for b in store.blocks(name)] == ["sine_low_027.344", "sine_low_060.000"]

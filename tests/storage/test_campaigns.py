"""Several runs become one campaign, with its provenance."""

from threading import Thread

import pytest
from recording import begin, noise, small_rig

from modallab.core.errors import StorageError
from modallab.storage import BlockNote, Store, campaign_of, rig_hash


def a_run(store: Store, *names: str, rig_name: str = "small", valid: bool = True) -> str:
    with begin(store, rig=small_rig(rig_name)) as recorder:
        for n, name in enumerate(names):
            recorder.record_block(noise(n), BlockNote(name, "impact", 64 * n))
        recorder.record_block(noise(99), BlockNote("bad", "impact", 0, accepted=False, reason="too weak: 1 N"))
        recorder.enter_state("done" if valid else "aborted", valid=valid)
    return recorder.run


def test_blocks_of_all_runs_in_the_order_of_time_with_unique_names(store: Store) -> None:
    runs = [a_run(store, "hit_1", "hit_2"), a_run(store, "hit_1")]
    campaign = campaign_of(store, runs)
    assert [(b.name, b.order) for b in campaign.blocks] == [("hit_1", 0), ("hit_2", 1), ("hit_1_run2", 2)]
    assert campaign.rig == small_rig()


def test_provenance_names_runs_bench_rates_code_and_rejections(store: Store) -> None:
    run = a_run(store, "hit_1")
    reported = campaign_of(store, [run]).provenance
    assert reported["runs"] == run
    assert reported["bench"] == "sim://somewhere"
    assert reported["bench.seed"] == "7"
    assert reported["rig_hash"] == rig_hash(small_rig())
    assert reported[f"{run}.actual_rate_hz"] == "1651.6"
    assert reported[f"{run}.rejected"] == "bad: too weak: 1 N"
    assert '"kind":"impact"' in reported[f"{run}.plan"]


def test_runs_of_different_rigs_are_rejected(store: Store) -> None:
    runs = [a_run(store, "hit_1"), a_run(store, "hit_1", rig_name="other")]
    with pytest.raises(StorageError, match="different rigs"):
        campaign_of(store, runs)


def test_an_aborted_run_is_left_out(store: Store) -> None:
    run = a_run(store, "hit_1", valid=False)
    with pytest.raises(StorageError, match="aborted"):
        campaign_of(store, [run])


def test_no_runs_are_rejected(store: Store) -> None:
    with pytest.raises(StorageError, match="no runs"):
        campaign_of(store, [])


def test_two_rigs_record_into_one_folder_at_the_same_time(store: Store) -> None:
    runs: list[str] = []

    def work() -> None:
        with Store(store.folder) as own:
            runs.append(a_run(own, *(f"hit_{n}" for n in range(20))))

    threads = [Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(len(store.blocks(run)) for run in runs) == [20] * 4

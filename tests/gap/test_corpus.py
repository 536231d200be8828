"""The corpus: its list, the figures drawn from results, its seals, and a run of an engine from end to end."""

import csv
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from corpus.campaigns import KINDS, chosen, entries, ordered
from corpus.compare import compared, paired
from corpus.results import COLUMNS, read
from corpus.sealed import entries as sealed_entries
from corpus.sealed import unsealed, write
from corpus.summary import figures

from modallab.blind.seal import seal_truth
from modallab.core.errors import DataError

GAP = Path(__file__).parents[2] / "benchmarks" / "gap"


def row(**own: object) -> dict[str, str]:
    return dict.fromkeys(COLUMNS, "") | {name: str(value) for name, value in own.items()}


def test_every_kind_and_set_has_the_campaigns_that_are_promised() -> None:
    listed = entries()
    assert len({e.id for e in listed}) == len(listed)
    sets = Counter(e.set for e in listed)
    assert (sets["practice"], sets["practice_rough"]) == (124, 52)
    assert (sets["own_built"], sets["own_ideal"], sets["structures"]) == (150, 40, 40)
    assert all(e.named for e in listed if e.set == "decisions")
    assert len(sealed_entries()) == 60
    built = Counter(e.kind for e in listed if e.set == "own_built")
    assert set(built) == set(KINDS) - {"structure"}
    assert len({e.effect for e in listed if e.set == "own_built"}) == 31 + 9 + 2


def test_wherever_a_run_ends_cheap_and_dear_campaigns_are_both_there() -> None:
    order = ordered(entries(), "stratified")
    assert sorted(e.id for e in order) == sorted(e.id for e in entries())
    first = Counter(e.kind for e in order[:40])
    assert set(first) == set(KINDS)
    assert first["none"] > first["single"] > first["unknown"] > 0
    assert len({e.set for e in order[:12]}) >= 5


def test_campaigns_are_chosen_by_kind_set_both_or_name() -> None:
    listed = entries()
    assert {e.kind for e in chosen(listed, ["stepped"])} == {"stepped"}
    assert {(e.kind, e.set) for e in chosen(listed, ["pair/practice"])} == {("pair", "practice")}
    assert [e.id for e in chosen(listed, ["rough_03"])] == ["rough_03"]


def test_figures_are_those_that_a_few_rows_add_up_to() -> None:
    rows = [
        row(kind="none", right=1, verdict="no_gap", seconds=2),
        row(kind="none", right=0, verdict="known", seconds=4, said="swap", probabilities='{"swap": 0.7}'),
        row(kind="pair", right=0, true="a+b", said="a", seconds=30, claims_right=1, probabilities='{"a": 0.9}',
            held='{"a k": true, "a x": false}', place_right=1),
        row(kind="unknown", right=1, true="torsion", verdict="unknown", seconds=8),
    ]  # fmt: skip
    found = {name: value for name, (value, _) in figures(rows).items()}
    assert found["right"] == 0.5
    assert found["one named"] == 1.0
    assert found["false alarms"] == 0.5
    assert found["unknown flagged"] == 1.0
    assert found["precision above 0.9"] == 1.0
    # Said 0.7 and was wrong, said 0.9 and was right, in bins of their own.
    assert found["calibration error"] == pytest.approx((0.7 + 0.1) / 2)
    assert found["intervals hold"] == 0.5
    assert found["seconds median"] == 6.0
    assert found["seconds worst"] == 30.0


def test_five_campaigns_that_one_engine_alone_has_right_are_a_chance_of_one_in_sixteen() -> None:
    first = [row(id=n, right=int(n < 2), seconds=8) for n in range(8)]
    second = [row(id=n, right=int(n < 7), seconds=2 if n % 2 else 8) for n in range(9)]
    found = compared(paired(first, second))
    assert (found.both, found.first, found.second, found.neither) == (2, 0, 5, 1)
    assert found.p == pytest.approx(2 / 2**5)
    assert found.seconds == pytest.approx(0.5)


def test_a_sealed_truth_cannot_be_read_in_the_file_nor_be_changed(tmp_path: Path) -> None:
    file, truth = tmp_path / "sealed.csv", {"effect": "swap", "seed": 7}
    hashes = {name: seal_truth(tmp_path, name, truth) for name in ("one", "other")}
    write(file, tmp_path, hashes)
    assert "swap" not in file.read_text()
    entry = sealed_entries(file)[0]
    assert entry.effect == ""
    assert (unsealed(entry, file).effect, unsealed(entry, file).seed) == ("swap", "7")
    with file.open(newline="") as source:
        rows = list(csv.reader(source))
    # The other's seal has a nonce of its own.
    rows[1][2] = rows[2][2]
    with file.open("w", newline="") as target:
        csv.writer(target).writerows(rows)
    with pytest.raises(DataError, match="not the one that was sealed"):
        unsealed(entry, file)


def scored(out: Path, *words: str) -> str:
    paths = os.pathsep.join([str(out.parent), os.environ.get("PYTHONPATH", "")])
    own = os.environ | {"MODALLAB_CORPUS": str(out.parent / "made"), "PYTHONPATH": paths}
    command = [sys.executable, "-m", "corpus.score", "--out", str(out), *words]
    return subprocess.run(command, cwd=GAP, env=own, check=True, capture_output=True, text=True).stdout


@pytest.mark.thorough("scores campaigns in processes of their own")
def test_the_two_cheapest_campaigns_are_scored_and_not_scored_again(tmp_path: Path) -> None:
    out = tmp_path / "results.csv"
    cheapest = ("--only", "own_built_none_1", "plate_none_0")
    scored(out, *cheapest, "--processes", "2")
    rows = read(out)
    assert {r["id"]: (r["verdict"], r["right"]) for r in rows} == dict.fromkeys(cheapest[1:], ("no_gap", "1"))
    assert all(0 < float(r["seconds"]) < 60 and r["gap_without_effects"] and r["commit"] and r["date"] for r in rows)
    assert "2 rows, 0 campaigns left" in scored(out, *cheapest)
    assert read(out) == rows


@pytest.mark.thorough("scores campaigns in processes of their own")
def test_an_engine_that_does_not_end_or_fails_has_a_row_that_says_so(tmp_path: Path) -> None:
    (tmp_path / "engines_of_a_test.py").write_text(
        "def endless(campaign, reference=None):\n    while True: pass\n\n\n"
        "def failing(campaign, reference=None):\n    raise ValueError('no such mode')\n"
    )
    for name in ("endless", "failing"):
        words = ("--engine", f"engines_of_a_test:{name}", "--only", "plate_gain_error_0", "--limit", "1")
        scored(tmp_path / "results.csv", *words)
    endless, failing = read(tmp_path / "results.csv")
    assert (endless["verdict"], endless["right"], endless["seconds"]) == ("over limit", "0", "1.0")
    assert (failing["verdict"], failing["error"]) == ("error", "ValueError: no such mode")
    assert {r["true"] for r in (endless, failing)} == {"gain_error"}

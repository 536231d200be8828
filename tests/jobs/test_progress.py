"""How far a computation is: parts of a whole, never backwards, and what the real work says of itself."""

from itertools import pairwise
from pathlib import Path

import pytest

from modallab.core.block import Campaign
from modallab.core.progress import count_progress, part_of_progress, report_progress, report_progress_to
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.jobs import JobDefinition
from modallab.pipelines.job_kinds import kinds

DATA = Path(__file__).parents[1] / "data"
Said = list[tuple[float, str]]


def listen(said: Said, share: float, stage: str) -> None:
    said.append((round(share, 6), stage))


def test_a_part_of_the_work_is_that_part_of_the_whole() -> None:
    said: Said = []
    with report_progress_to(lambda share, stage: listen(said, share, stage)):
        with part_of_progress(0.0, 0.5, "first"):
            report_progress(0.5, "half of it")
        with part_of_progress(0.5, 1.0, "second"), part_of_progress(0.0, 0.5):
            assert list(count_progress("ab", 2, "letters")) == ["a", "b"]
    assert said == [
        (0.0, "first"), (0.25, "first: half of it"), (0.5, "first"),
        (0.5, "second"), (0.5, "second"), (0.625, "second: letters, 1 of 2"), (0.75, "second: letters, 2 of 2"),
        (0.75, "second"), (1.0, "second"),
    ]  # fmt: skip


def test_nobody_need_listen() -> None:
    with part_of_progress(0.0, 1.0):
        report_progress(0.5)
    assert list(count_progress([1], 1)) == [1]


def hits(_inputs: tuple[str, ...]) -> Campaign:
    return read_campaign(DATA / "hammer_5hits.h5", read_rig(DATA / "hammer_rig.yaml"))


def computed(kind: JobDefinition, campaign: Campaign, parameters: dict[str, object]) -> Said:
    said: Said = []
    payload = campaign, kind.load(parameters, ("x",))[1]  # type: ignore[arg-type]
    kind.compute(payload, lambda share, stage="": listen(said, share, stage))
    return said


def require_moving(said: Said, *stages: str) -> None:
    shares = [share for share, _ in said]
    assert shares == sorted(shares), "it goes back"
    assert shares[0] < 0.1
    assert len(set(shares)) >= 10
    assert max(b - a for a, b in pairwise(shares)) < 0.4
    for stage in stages:
        assert any(stage in words for _, words in said), stage


@pytest.mark.thorough("identifies hits of a real structure")
def test_identification_says_how_far_its_search_is(tmp_path: Path) -> None:
    kind = kinds(hits, tmp_path)[0]
    said = computed(kind, hits(()), {"band_hz": [500, 1500]})
    require_moving(said, "impact test: first search: step 1", "impact test: assessment")

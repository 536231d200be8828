"""Answers: each a diagnosis by a process that is given a campaign and nothing else."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from modallab.blind.seal import hash_of
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import FormatError
from modallab.core.progress import report_progress
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose

ANSWERS = "answers.jsonl"
Item = TypeVar("Item")
Given = TypeVar("Given")


@dataclass(frozen=True, slots=True)
class TrialAnswer:
    """What was said of a campaign.

    Attributes:
        name: of the trial.
        diagnosis: of its campaign.
        seconds: processor time it took.
        length_m: of the beam.
        withheld: names that were taken out of the candidates.
    """

    name: str
    diagnosis: Diagnosis
    seconds: float
    length_m: float
    withheld: frozenset[str] = frozenset()


def answer_trial(campaign: Path, withheld: frozenset[str] = frozenset()) -> dict[str, Any]:
    """Diagnose a campaign; the answer as it is written down, but for its name."""
    read = read_campaign(campaign)
    begun = time.process_time()
    diagnosis = diagnose(read, allowed=lambda effect: effect not in withheld)
    seconds = time.process_time() - begun
    length = read.rig.beam.length_m if read.rig.beam is not None else 1.0
    more = {"withheld": sorted(withheld)} if withheld else {}
    return {"seconds": seconds, "length_m": length, "diagnosis": diagnosis.model_dump(mode="json")} | more


def answer_trials(campaigns: dict[str, Path], out: Path, pool: Executor | None) -> str:
    """Answer what the file does not hold yet, one line each; gives the hash of the file once all is answered."""
    there = {answer.name for answer in read_answers(out)}
    left = [(name, path) for name, path in campaigns.items() if name not in there]
    with out.open("a", encoding="utf-8", newline="\n") as target:
        for (name, _), entry in compute_in_pool(pool, lambda pair: (answer_trial, pair[1]), left, "diagnosed"):
            target.write(json.dumps({"name": name} | entry) + "\n")
            target.flush()
    return hash_of(out.read_text(encoding="utf-8"))


def read_answers(file: Path) -> list[TrialAnswer]:
    """The answers in a file; a last line that was cut off by the end of its process is left out.

    Raises:
        FormatError: a line is no answer.
    """
    lines = file.read_text(encoding="utf-8").split("\n") if file.exists() else [""]
    if lines[-1]:
        # Whatever is written next begins a line of its own.
        file.write_text("".join(line + "\n" for line in lines[:-1]), encoding="utf-8", newline="\n")
    return [_read_answer(line, f"{file}, line {number}") for number, line in enumerate(lines[:-1], 1)]


def _read_answer(line: str, where: str) -> TrialAnswer:
    try:
        entry: dict[str, Any] = json.loads(line)
        diagnosis = Diagnosis.model_validate(entry["diagnosis"])
        withheld = frozenset(entry.get("withheld", ()))
        return TrialAnswer(entry["name"], diagnosis, entry["seconds"], entry.get("length_m", 1.0), withheld)
    except (ValueError, KeyError) as error:
        raise FormatError(
            f"is no answer: {error}", where=where, remedy="delete that line; its trial is then diagnosed again"
        ) from error


def compute_in_pool(
    pool: Executor | None,
    call: Callable[[Item], tuple[Callable[..., Given], Any]],
    items: Sequence[Item],
    stage: str,
) -> Iterator[tuple[Item, Given]]:
    """Each item with what its call gives, as they come; says how far it is.

    Args:
        pool: computes; None: this process, one after another.
        call: from an item to a function of a module and its one argument.
        items: to be computed.
        stage: what is being done, in words.
    """
    for number, pair in enumerate(
        _compute_in_turn(call, items) if pool is None else _compute_in_processes(pool, call, items), 1
    ):
        report_progress(number / len(items), f"{stage} {number} of {len(items)}")
        yield pair


def _compute_in_turn(
    call: Callable[[Item], tuple[Callable[..., Given], Any]], items: Sequence[Item]
) -> Iterator[tuple[Item, Given]]:
    for item in items:
        compute, given = call(item)
        yield item, compute(given)


def _compute_in_processes(
    pool: Executor, call: Callable[[Item], tuple[Callable[..., Given], Any]], items: Sequence[Item]
) -> Iterator[tuple[Item, Given]]:
    futures = {pool.submit(*call(item)): item for item in items}
    done: Iterable[Any] = as_completed(futures)
    for future in done:
        yield futures[future], future.result()

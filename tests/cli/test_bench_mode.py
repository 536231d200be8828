"""The terminal at the bench: what is shown, which tones are played, and what keys do to a running test."""

import json
import os
import socket
import subprocess
import sys
import wave
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from modallab.cli.terminal_mode.keys import KeyMap
from modallab.cli.terminal_mode.operator import LOOKS, big_letters, status_sentence
from modallab.cli.terminal_mode.session_state import SessionState
from modallab.cli.terminal_mode.tones import RATE_HZ, TONES, write_tone
from modallab.core.documents.pages import EventView
from modallab.core.errors import ConfigurationError
from modallab.core.events import (
    BlockAcknowledged,
    Event,
    HitRejected,
    HitRequested,
    HitTooEarly,
    StateChanged,
    WaitingForRest,
)
from modallab.storage import Store


def after(*events: Event) -> SessionState:
    state = SessionState()
    for n, event in enumerate(events):
        view = EventView(
            seq=n, utc="", kind=event.kind, rig="r", campaign="c", run=event.run, content=event.model_dump(mode="json")
        )
        state = state.after_event(view)
    return state


ASKED = HitRequested(run="a", point=3, hit=2, of=5)
REST = WaitingForRest(
    run="a", point=3, hit=2, of=5, residual_ratio=0.2, allowed=0.01, residual_hz=4.88, remaining_s=7.4
)


def block(n: int, *, accepted: bool) -> BlockAcknowledged:
    return BlockAcknowledged(run="a", n=n, name="b", first_sample=0, count=1, crc32=0, accepted=accepted)


def test_the_prompt_says_which_point_and_when() -> None:
    assert status_sentence(after(ASKED)) == "strike point 3, hit 2 of 5"
    assert "4.88 Hz rings with 20 % of a hit, 1 % is allowed" in status_sentence(after(REST))
    assert "7 s" in status_sentence(after(REST))
    assert after(StateChanged(run="a", state="paused")).phase == "paused"


def test_why_a_hit_does_not_count_stays_until_the_next() -> None:
    no = HitRejected(run="a", point=3, reason="this looks like point 10; 3 was requested")
    state = after(ASKED, block(4, accepted=False), no, REST)
    assert (state.phase, state.news, state.last_rejected) == ("wait", f"rejected: {no.reason}", 4)
    state = after(ASKED, block(4, accepted=False), no, REST, ASKED, block(5, accepted=True))
    assert (state.phase, state.news, state.last_rejected, state.last_good) == ("good", "", None, 5)


def test_an_early_hit_is_called_so() -> None:
    state = after(REST, HitTooEarly(run="a", point=3, peak_n=41.0))
    assert state.phase == "early"
    assert "wait for the tone" in state.news


@pytest.mark.parametrize("width", [40, 80, 200])
def test_every_word_fits_its_terminal(width: int) -> None:
    for word in [*(word for word, _ in LOOKS.values()), "10", "128"]:
        assert max(map(len, big_letters(word, width))) <= width
    assert len(big_letters("10", 200)) > len(big_letters("10", 40)) or width
    assert len(big_letters("STRIKE", 80, 1)) == 5


def test_a_pedal_gets_a_meaning_and_the_other_keys_stay() -> None:
    keys = KeyMap.read("undo=pagedown,accept=b")
    assert [keys.action_of(typed) for typed in ("\x1b[6~", "b", "p", "q", "a", "u")] == [
        "undo", "accept", "pause", "quit", None, None,
    ]  # fmt: skip


@pytest.mark.parametrize("text", ["undo=a", "jump=j", "undo=pedal", "undo"])
def test_a_map_that_cannot_be_is_rejected(text: str) -> None:
    with pytest.raises(ConfigurationError, match="--keys"):
        KeyMap.read(text)


def test_the_four_tones_differ_in_pitch_or_rhythm(tmp_path: Path) -> None:
    tones_played: set[tuple[int, ...]] = set()
    for phase, parts in TONES.items():
        write_tone(tmp_path / "tone.wav", parts)
        with wave.open(str(tmp_path / "tone.wav")) as file:
            assert file.getframerate() == RATE_HZ
            samples = np.frombuffer(file.readframes(file.getnframes()), dtype="<i2")
        first = samples[: round(parts[0][1] * RATE_HZ)]
        loudest = np.argmax(np.abs(np.fft.rfft(first))) / parts[0][1]
        assert loudest == pytest.approx(parts[0][0], rel=0.02), phase
        tones_played.add(tuple(round(hz) for hz, _ in parts))
    assert len(tones_played) == 4


@pytest.fixture
def command(tmp_path: Path) -> tuple[list[str], int]:
    """The program on a bench whose hammer is swung by whoever sends datagrams, and their port."""
    rig, plan = tmp_path / "rig.yaml", tmp_path / "plan.yaml"
    rig.write_bytes((resources.files("modallab.cli") / "link_rig.yaml").read_bytes())
    plan.write_text("{kind: impact, points: [3], hits: 2}\n", encoding="utf-8")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    bench = f"sim://cantilever?seed=1&zeta=0.05&pace=1&speed=4&operator={port}"
    start = "import sys; from modallab.cli import main; sys.exit(main(sys.argv[1:]))"
    words = ["campaign", "run", "--rig", str(rig), "--plan", str(plan), "--bench", bench, "--data", str(tmp_path / "d")]
    return [sys.executable, "-u", "-c", start, *words, "--mute"], port


@pytest.mark.thorough("waits for a bench that goes by the clock")
def test_keys_act_on_the_running_test_and_the_bench_on_whoever_strikes(
    command: tuple[list[str], int], tmp_path: Path
) -> None:
    words, port = command
    process = subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={**os.environ, "COLUMNS": "80"}
    )
    assert process.stdin is not None
    assert process.stdout is not None
    seen: list[str] = []

    def until(text: str) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            seen.append(line)
            if text in line:
                return
        raise AssertionError(f"{text!r} never came: {seen}")

    def press(key: str) -> None:
        assert process.stdin is not None
        process.stdin.write(f"{key}\n")
        process.stdin.flush()

    def strike(point: int) -> None:
        act = json.dumps({"act": "strike", "point": point, "after_s": 0.2}).encode()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            out.sendto(act, ("127.0.0.1", port))

    until("strike point 3, hit 1 of 2")
    strike(9)
    until("rejected: this looks like point 9; 3 was requested")
    press("a")
    until("1/2")
    until("strike point 3, hit 2 of 2")
    press("p")
    until("pause")
    press("p")
    until("strike point 3, hit 2 of 2")
    press("u")
    press("q")
    process.stdin.close()
    process.stdout.read()
    process.stdout.close()
    process.wait(60)
    with Store(tmp_path / "d") as store:
        (run,) = store.catalogue.runs()
        (row,) = store.catalogue.blocks(run.id)
    assert (run.state, run.reason) == ("done", "stopped by the operator")
    assert row.note.reason.startswith("accepted at the bench (by ")

"""Ties the events of a session to screen and tones, and the operator's keys to the running test."""

from dataclasses import replace
from threading import Lock

from rich.console import Console

from modallab.cli.bench_mode.keys import KeyMap, Meaning
from modallab.cli.bench_mode.screen import Screen, sentence
from modallab.cli.bench_mode.session_state import SessionState
from modallab.cli.bench_mode.tones import Tones
from modallab.core.documents.pages import EventView
from modallab.core.documents.runs import Accept, Command, Drop, Pause, Resume, Stop
from modallab.core.errors import ModallabError
from modallab.service.campaigns.local_session import LocalCampaign


class Operator:
    """The operator's end of a session: `notify` gets its events, `pressed` the keys, from any thread.

    Attributes:
        left: whether the operator has ended the session.
    """

    def __init__(self, console: Console, keys: KeyMap, session: LocalCampaign, *, mute: bool) -> None:
        self._console, self._session = console, session
        self._screen = Screen(console, keys) if console.is_terminal else None
        self._tones = Tones(mute=mute)
        self._state = SessionState()
        self._lock = Lock()
        self.left = False

    def notify(self, event: EventView) -> None:
        """Show what an event means to the operator."""
        with self._lock:
            before, self._state = self._state, self._state.after(event)
            state = self._state
            if state == before:
                return
            if state.phase != before.phase or event.kind in ("hit_too_early", "hit_rejected", "hit_requested"):
                self._tones.play(state.phase)
            self._show(state, before)

    def pressed(self, meaning: Meaning) -> None:
        """Do what a key means; what cannot be done now is shown, and the test goes on."""
        with self._lock:
            state = self._state
            command = _command(meaning, state)
            self.left = self.left or meaning == "quit"
        if command is None:
            return
        try:
            self._session.command(state.run, command)
        except ModallabError as error:
            self._console.print(error.what, markup=False, highlight=False)

    def close(self) -> None:
        """End the tones."""
        self._tones.close()

    def _show(self, state: SessionState, before: SessionState) -> None:
        if self._screen is not None:
            self._screen.show(state)
            return
        if replace(state, text="") == replace(before, text="") and state.phase == "wait":
            # One line a wait: the countdown is for a screen.
            return
        lines = [f"{state.done}/{state.total}  {sentence(state)}"]
        if state.news != before.news and state.news:
            lines.insert(0, state.news)
        self._console.print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _command(meaning: Meaning, state: SessionState) -> Command | None:
    if meaning == "pause":
        return Resume() if state.phase == "paused" else Pause()
    if meaning == "quit":
        return Stop()
    if meaning == "undo":
        return None if state.last_good is None else Drop(n=state.last_good, reason="taken back by the operator")
    return None if state.last_rejected is None else Accept(n=state.last_rejected)

"""Ties the events of a session to screen, tones and the simulation, and the operator's keys to the running test."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import Condition, Lock, Thread

import numpy as np
from rich.align import Align
from rich.console import Console, Group
from rich.text import Text

from modallab.cli.terminal_mode.keys import KeyMap, Meaning
from modallab.cli.terminal_mode.session_state import Phase, SessionState
from modallab.cli.terminal_mode.tones import Tones
from modallab.core.block import Campaign
from modallab.core.documents.pages import EventView
from modallab.core.documents.runs import AcceptHit, Command, DropHit, PauseRun, ResumeRun, StopRun
from modallab.core.errors import ConfigurationError, ModallabError
from modallab.core.setups import SensorMove
from modallab.service.campaigns.local_session import LocalCampaign

GLYPHS = {
    "0": "###|#.#|#.#|#.#|###", "1": ".#.|##.|.#.|.#.|###", "2": "###|..#|###|#..|###", "3": "###|..#|.##|..#|###",
    "4": "#.#|#.#|###|..#|..#", "5": "###|#..|###|..#|###", "6": "###|#..|###|#.#|###", "7": "###|..#|..#|.#.|.#.",
    "8": "###|#.#|###|#.#|###", "9": "###|#.#|###|..#|###",
    "A": ".#.|#.#|###|#.#|#.#", "B": "##.|#.#|##.|#.#|##.", "C": "###|#..|#..|#..|###", "D": "##.|#.#|#.#|#.#|##.",
    "E": "###|#..|##.|#..|###", "F": "###|#..|##.|#..|#..", "G": "###|#..|#.#|#.#|###", "H": "#.#|#.#|###|#.#|#.#",
    "I": "#|#|#|#|#", "J": "..#|..#|..#|#.#|###", "K": "#.#|#.#|##.|#.#|#.#", "L": "#..|#..|#..|#..|###",
    "M": "#...#|##.##|#.#.#|#...#|#...#", "N": "#..#|##.#|#.##|#..#|#..#", "O": "###|#.#|#.#|#.#|###",
    "P": "###|#.#|###|#..|#..", "Q": "###|#.#|#.#|###|..#", "R": "##.|#.#|##.|#.#|#.#", "S": "###|#..|###|..#|###",
    "T": "###|.#.|.#.|.#.|.#.", "U": "#.#|#.#|#.#|#.#|###", "V": "#.#|#.#|#.#|#.#|.#.",
    "W": "#...#|#...#|#.#.#|##.##|#...#", "X": "#.#|#.#|.#.|#.#|#.#", "Y": "#.#|#.#|.#.|.#.|.#.",
    "Z": "###|..#|.#.|#..|###", " ": ".|.|.|.|.",
}  # fmt: skip
ROWS = 5


def big_letters(text: str, width: int, largest: int = 3) -> list[str]:
    """Lines of a text in the largest letters that fit into `width` columns; the text itself where none does."""
    glyphs = [GLYPHS[letter].split("|") for letter in text.upper() if letter in GLYPHS]
    for scale in range(largest, 0, -1):
        lines = [_row(glyphs, row, scale) for row in range(ROWS) for _ in range(scale)]
        if max(map(len, lines)) <= width:
            return lines
    return [text]


def _row(glyphs: list[list[str]], row: int, scale: int) -> str:
    blocks = (glyph[row].replace("#", "\N{FULL BLOCK}" * 2 * scale) for glyph in glyphs)
    return ("  " * scale).join(part.replace(".", "  " * scale) for part in blocks)


LOOKS: dict[Phase, tuple[str, str]] = {
    "begin": ("WAIT", "yellow"),
    "wait": ("WAIT", "yellow"),
    "strike": ("STRIKE", "bold green"),
    "record": ("WAIT", "yellow"),
    "good": ("GOOD", "bold cyan"),
    "rejected": ("AGAIN", "bold red"),
    "early": ("TOO EARLY", "bold magenta"),
    "paused": ("PAUSE", "bold blue"),
    "move": ("MOVE", "bold blue"),
    "drive": ("SINE", "yellow"),
    "ended": ("END", "bold white"),
}
"""Word and colour of each phase."""


def status_sentence(state: SessionState) -> str:
    """What the screen says, in one line of words."""
    word = LOOKS[state.phase][0].lower()
    where = f" point {state.point}, hit {state.hit} of {state.of}" if state.point else ""
    text = f": {state.text}" if state.text else ""
    return f"{word}{where}{text}"


class TerminalScreen:
    """Paints the whole terminal at every change."""

    def __init__(self, console: Console, keys: KeyMap) -> None:
        self._console = console
        self._keys = keys

    def show(self, state: SessionState) -> None:
        """Paint a state."""
        word, style = LOOKS[state.phase]
        width = self._console.width
        lines = big_letters(word, width, 1)
        if state.point:
            lines += ["", *big_letters(str(state.point), width, 2)]
        prompt = Text("\n".join(lines), style=style, justify="left", no_wrap=True)
        news = Text(state.news, style="cyan" if state.phase == "good" else "bold red", overflow="fold")
        below = Text(
            f"{status_sentence(state)}\n{state.done}/{state.total}   {self._keys.help()}\n{state.compared}",
            overflow="fold",
        )
        self._console.clear()
        self._console.print(Group(Align.center(prompt), news, below))


LOOK_S = 0.2
_LEAVE_S = 5.0
"""How long a comparison that is on may take once the session ends."""


class TerminalOperator:
    """The operator's end of a session: `notify` gets its events, `pressed` the keys, from any thread.

    Attributes:
        left: whether the operator has ended the session.
    """

    def __init__(self, console: Console, keys: KeyMap, session: LocalCampaign, *, mute: bool) -> None:
        self._console, self._session = console, session
        self._screen = TerminalScreen(console, keys) if console.is_terminal else None
        self._tones = Tones(mute=mute)
        self._state = SessionState()
        self._lock = Lock()
        self._done = Condition(self._lock)
        self._keys = keys
        self.left = False
        has_beam = session.rig.beam is not None
        self._agreement = _AgreementWatch(lambda run: session.recorded((run,)), self._compared) if has_beam else None

    def notify(self, event: EventView) -> None:
        """Show what an event means to the operator."""
        with self._lock:
            before, self._state = self._state, self._state.after_event(event)
            state = self._state
            if state == before:
                return
            if state.phase != before.phase or event.kind in ("hit_too_early", "hit_rejected", "hit_requested"):
                self._tones.play(state.phase)
            self._show(state, before)
            if self._agreement is not None and state.last_good is not None and state.last_good != before.last_good:
                self._agreement.request(state.run)

    def _compared(self, sentence: str) -> None:
        """Show whether the simulation agrees with what was recorded."""
        with self._lock:
            before, self._state = self._state, replace(self._state, compared=sentence)
            if self._state != before:
                self._show(self._state, before)

    def handle_key(self, meaning: Meaning) -> None:
        """Do what a key means; what cannot be done now is shown, and the test goes on."""
        with self._lock:
            state = self._state
            self.left = self.left or meaning == "quit"
            if state.phase == "move":
                self._state = self._state if meaning != "pause" else replace(state, phase="begin", text="")
                self._done.notify_all()
                return
            command = _command(meaning, state)
        if command is None:
            return
        try:
            self._session.command(state.run, command)
        except ModallabError as error:
            self._console.print(error.what, markup=False, highlight=False)

    def confirm_sensor_moves(self, setup: str, moves: Sequence[SensorMove], key_pressed: Callable[[], bool]) -> bool:
        """Say which sensors to move, and wait for the key that says they are; False if the operator quits instead.

        Args:
            setup: name of the set-up.
            moves: what to move.
            key_pressed: whether a key can still come.

        Raises:
            ConfigurationError: no key can come.
        """
        with self._lock:
            before, self._state = self._state, SessionState(phase="move", text=self._to_move(setup, moves))
            self._show(self._state, before)
            while self._state.phase == "move" and not self.left:
                if not key_pressed():
                    raise ConfigurationError(
                        f"sensors must be moved for set-up {setup}, but no key can confirm the move",
                        remedy="start the command with a keyboard, or with a pipe that stays open",
                    )
                self._done.wait(LOOK_S)
        return not self.left

    def _to_move(self, setup: str, moves: Sequence[SensorMove]) -> str:
        each = ", ".join(f"{m.channel} from {'nowhere' if m.before is None else m.before} to {m.after}" for m in moves)
        return f"set-up {setup}: {each}; then press {self._keys.names['pause']}"

    def close(self) -> None:
        """End the tones and the comparison with the simulation."""
        self._tones.close()
        if self._agreement is not None:
            self._agreement.close()

    def _show(self, state: SessionState, before: SessionState) -> None:
        if self._screen is not None:
            self._screen.show(state)
            return
        if replace(state, text="") == replace(before, text="") and state.phase == "wait":
            # One line a wait: the countdown is for a screen.
            return
        lines = [f"{state.done}/{state.total}  {status_sentence(state)}"]
        if state.compared != before.compared:
            lines = [state.compared]
        if state.news != before.news and state.news:
            lines.insert(0, state.news)
        self._console.print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _command(meaning: Meaning, state: SessionState) -> Command | None:
    if meaning == "pause":
        return ResumeRun() if state.phase == "paused" else PauseRun()
    if meaning == "quit":
        return StopRun()
    if meaning == "undo":
        return (
            None
            if state.last_good is None
            else DropHit(n=state.last_good, reason="rejected by the operator afterwards")
        )
    return None if state.last_rejected is None else AcceptHit(n=state.last_rejected)


class _AgreementWatch:
    """Compares the latest records of a run each time it is notified; a request replaces one that waits."""

    def __init__(self, recorded: Callable[[str], Campaign], show: Callable[[str], None]) -> None:
        """Begin to wait for requests.

        Args:
            recorded: what a run has recorded so far.
            show: takes the sentence of each comparison, in a thread of its own.
        """
        self._recorded, self._show = recorded, show
        self._requested: str | None = None
        self._closed = False
        self._changed = Condition()
        self._thread = Thread(target=self._compare_all, name="agreement", daemon=True)
        self._thread.start()

    def request(self, run: str) -> None:
        """Compare this run with the simulation, as soon as the comparison before is done."""
        with self._changed:
            self._requested = run
            self._changed.notify()

    def close(self) -> None:
        """Begin no other comparison, and wait for the one that is on."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(_LEAVE_S)

    def _compare_all(self) -> None:
        while (run := self._next()) is not None:
            self._compare(run)

    def _next(self) -> str | None:
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._requested is not None)
            run, self._requested = self._requested, None
            return None if self._closed else run

    def _compare(self, run: str) -> None:
        from modallab.gap.inference.agreement import agreement, records_of_last_setting

        try:
            self._show(agreement(records_of_last_setting(self._recorded(run))).sentence)
        except (ModallabError, np.linalg.LinAlgError):
            # Too little is recorded yet, or a record shows no mode: the next one is compared.
            return

"""The screen of the bench mode: one colour and one word for what to do now, and the point in letters of blocks."""

from rich.align import Align
from rich.console import Console, Group
from rich.text import Text

from modallab.cli.bench_mode.big_text import big_letters
from modallab.cli.bench_mode.keys import KeyMap
from modallab.cli.bench_mode.session_state import Phase, SessionState

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


class Screen:
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

"""The screen of the bench mode: one colour and one word for what to do now, and the point in letters of blocks."""

from rich.align import Align
from rich.console import Console, Group
from rich.text import Text

from modallab.cli.terminal_mode.keys import KeyMap
from modallab.cli.terminal_mode.session_state import Phase, SessionState

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

"""Words and numbers in letters of blocks, to be read from two metres."""

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

"""Whether a command printed what a page says it prints.

Words are compared one after another; where lines break, ruled lines and the width of columns do not count. `...` alone
on a line stands for any words. Numbers may differ by 1e-5, or by one in the last digit that the page shows, which is
that of one machine's rounding; their uncertainties by more. Times of day and durations are not compared.
"""

import re
from itertools import zip_longest

TOLERANCE = 1e-5

_NUMBER = re.compile(r"([-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)(?:\([\d.?]+\))?(\D*)")
_CLOCK = re.compile(r"\d+:\d\d:\d\d")
_RULE = re.compile(r"[─━╺╸┃│┏┓┡┩└┘┳╇┴]+")


def difference(said: list[str], printed: list[str]) -> str:
    """What a page says that was not printed, or "" if all of it was."""
    parts = [_words(part) for part in _parts(said)]
    words = _words(printed)
    if len(parts) == 1:
        return _first_difference(parts[0], words)
    at = len(parts[0])
    wrong = _first_difference(parts[0], words[:at])
    for part in parts[1:-1]:
        found = next((i for i in range(at, len(words)) if not _first_difference(part, words[i : i + len(part)])), None)
        wrong = wrong or ("" if found is not None else f"nowhere is printed: {' '.join(part)}")
        at = len(words) if found is None else found + len(part)
    last = parts[-1]
    return wrong or _first_difference(last, words[max(at, len(words) - len(last)) :] if last else [])


def _parts(said: list[str]) -> list[list[str]]:
    parts: list[list[str]] = [[]]
    for line in said:
        if line.strip() == "...":
            parts.append([])
        else:
            parts[-1].append(line)
    return parts


def _words(lines: list[str]) -> list[str]:
    return [word for line in lines for word in line.split() if not _RULE.fullmatch(word)]


def _first_difference(said: list[str], printed: list[str]) -> str:
    for i, (a, b) in enumerate(zip_longest(said, printed)):
        measured = said[i + 1 : i + 3] == ["noise", "units"]
        if a is None or b is None or not _same(a, b, measured):
            near = slice(max(0, i - 5), i + 6)
            there = " ".join(printed[near]) or "(nothing)"
            return f"the page says\n  {' '.join(said[near]) or '(nothing)'}\nand there is\n  {there}"
    return ""


def _same(said: str, printed: str, measured: bool) -> bool:
    if said == printed or (_CLOCK.fullmatch(said) and _CLOCK.fullmatch(printed)):
        return True
    a, b = _NUMBER.fullmatch(said), _NUMBER.fullmatch(printed)
    if a is None or b is None or a[2] != b[2]:
        return False
    return abs(float(a[1]) - float(b[1])) <= max(TOLERANCE * abs(float(a[1])), 1.001 * _last_digit(a[1], measured))


def _last_digit(number: str, measured: bool) -> float:
    """One in the last digit of a number as it is written; of a whole number nothing, since it may be a count.

    Noise units are none: a gap in three digits is that of one machine's fit.
    """
    digits, _, power = number.lower().partition("e")
    _, point, behind = digits.partition(".")
    return 10.0 ** (int(power or 0) - len(behind)) if point or measured else 0.0

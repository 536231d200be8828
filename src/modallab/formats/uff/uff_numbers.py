"""Numbers as universal files hold them, one syntax for all datasets: whatever Fortran and its readers take for one.

Exponents begin with E or D in either case, or with their sign alone where they have three digits; their sign may be a
blank. Columns may touch where the next number has a sign, and rows may be of any length. The standard prescribes
columns; programs follow it more or less.
"""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError

_MANTISSA = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_NUMBER = re.compile(
    rf"{_MANTISSA}(?:[EeDd] ?[+-]?\d+|[+-]\d{{3}})?(?![\d.EeDd])|[+-]?(?:nan|inf(?:inity)?)\b", re.IGNORECASE
)
_PARTS = re.compile(rf"({_MANTISSA})(?:[EeDd]? ?([+-]?\d+))?")
_OLD_EXPONENT = str.maketrans("Dd", "EE")
EXPORT_AGAIN = "copy the file again, or export it again from the analyser"


def numbers(lines: Sequence[str], where: str) -> NDArray[np.float64]:
    """(n,) all numbers of some lines, in their order.

    Raises:
        FormatError: names the first line with something else, and what stands there.
    """
    text = "\n".join(lines)
    try:
        return np.array(text.translate(_OLD_EXPONENT).split(), np.float64)
    except ValueError:
        return np.array([_value(token) for line in lines for token in _tokens(line, where)], np.float64)


def plain_line(line: str) -> str:
    """A line as pyuff reads it: where it holds nothing but numbers, exponents begin with E; columns stay."""
    text = line.rstrip()
    return text.translate(_OLD_EXPONENT) if _NUMBER.sub("", text).strip() == "" else text


def _tokens(line: str, where: str) -> list[str]:
    rest = _NUMBER.sub(" ", line).split()
    if rest:
        found = f"{rest[0]!r} in the line {line.strip()[:80]!r} is no number"
        raise FormatError(found, where=where, remedy=EXPORT_AGAIN)
    return [found.group() for found in _NUMBER.finditer(line)]


def _value(token: str) -> float:
    parts = _PARTS.fullmatch(token)
    return float(token) if parts is None else float(f"{parts[1]}E{parts[2] or 0}")

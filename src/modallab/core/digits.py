"""Numbers for people, everywhere: as many digits as the uncertainty bears, and no more; shares in percent."""

import math
import re
from collections.abc import Sequence
from datetime import date

UNKNOWN = "unknown"
NONE = "–"
"""In a table, where there is no number."""
IN_95 = 2 * 1.96
"""Standard deviations in a 95 % interval."""
CERTAIN = 0.99
"""No probability is stated higher."""
LEAST_PERCENT = 0.01
"""Below it no digits are given."""
LARGE = 1e6
"""From here on a number reads better with an exponent."""
_UNIT = re.compile(r"(?<=[\d⁻⁰¹²³⁴⁵⁶⁷⁸⁹]) (?=(%|Hz|kHz|s|ms|m|mm|N|GPa|kg|g|V|sigmas?|bit|±|σ)(?![a-zA-Z]))|(?<=±) ")


def with_sigma(value: float, sigma: float) -> str:
    """`4.8021 ± 0.0003`: the sigma to one digit (two if it starts with 1), the value to the same place.

    A sigma that is not known is said so, and the value is given to four digits.
    """
    if not math.isfinite(value):
        return UNKNOWN
    if not (math.isfinite(sigma) and sigma > 0):
        return f"{significant_digits(value)} (± {UNKNOWN})"
    places = _places(sigma)
    return f"{_fixed_places(value, places)} ± {_fixed_places(sigma, places)}"


def number_with_sigma(value: float, sigma: float) -> str:
    """`4.8021(3)`: the sigma in brackets counts in the last places of the value; where it is not known, `4.802(?)`."""
    if not math.isfinite(value):
        return UNKNOWN
    if not (math.isfinite(sigma) and sigma > 0):
        return f"{significant_digits(value)}(?)"
    places = _places(sigma)
    return f"{_fixed_places(value, places)}({round(sigma * 10**places) if sigma < 1 else _fixed_places(sigma, places)})"


def with_interval(value: float, interval: tuple[float, float] | None, unit: str = "") -> tuple[str, str]:
    """A number and its 95 % interval to the digits that its uncertainty bears; "" for an interval that is not known."""
    tail = f" {unit}" if unit else ""
    if interval is None or not all(map(math.isfinite, interval)) or interval[1] <= interval[0]:
        return f"{significant_digits(value)}{tail}", ""
    sigma = (interval[1] - interval[0]) / IN_95
    low, high = (rounded_to_sigma(v, sigma) for v in interval)
    return f"{rounded_to_sigma(value, sigma)}{tail}", f"{low} to {high}{tail}"


def rounded_to_sigma(value: float, sigma: float) -> str:
    """A value without uncertainty of its own, to the places of one that has the sigma."""
    if not math.isfinite(value):
        return UNKNOWN
    known = math.isfinite(sigma) and sigma > 0
    return _fixed_places(value, _places(sigma)) if known else significant_digits(value, 5)


def significant_digits(value: float, digits: int = 4) -> str:
    """A number to so many significant digits, without exponent where it reads better."""
    if not math.isfinite(value):
        return UNKNOWN
    if value == 0:
        return "0"
    # Of what it rounds to: 9.96 to two digits is 10.
    place = digits - 1 - int(f"{value:.{digits - 1}e}".split("e")[1])
    if -6 <= place <= 8:
        return _fixed_places(value, max(place, 0))
    return scientific_text(value, digits)


def one_digit(value: float) -> str:
    """To one digit: 200, 7×10⁷."""
    return significant_digits(float(f"{value:.1g}"), 1)


def scientific_text(value: float, digits: int = 3) -> str:
    """`1.23×10⁻⁵`."""
    if not math.isfinite(value):
        return UNKNOWN
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa}×10{superscript_text(int(exponent))}".replace("-", "−")


def four_places(value: float) -> str:
    """A number between 0 and 1 such as FRAC or MAC, to four places."""
    return f"{value:.4f}" if math.isfinite(value) else UNKNOWN


def superscript_text(number: int) -> str:
    """An integer in raised figures."""
    return str(number).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def percent_text(share: float | None, digits: int = 2) -> str:
    """A share as `3.2 %` or `5 %`, without an exponent: `100 %`, `below 0.01 %`; a dash where there is none."""
    if share is None:
        return NONE
    if not math.isfinite(share):
        return UNKNOWN
    value = 100 * share
    if 0 < abs(value) < LEAST_PERCENT:
        return f"below {LEAST_PERCENT} %"
    shown = significant_digits(value, digits)
    return f"{shown.rstrip('0').rstrip('.') if '.' in shown else shown} %"


def share_text(share: float) -> str:
    """A part of a whole, to a tenth of a percent: `99.7 %`."""
    value = round(100 * share, 1)
    return f"{_fixed_places(value if value else 0.0, 1)} %"


def relative_change(share: float) -> str:
    """A relative change in percent with its sign, to two digits: `+0.40 %`."""
    if not math.isfinite(share):
        return UNKNOWN
    value = 100 * share
    if value == 0:
        return "0 %"
    places = min(max(1 - math.floor(math.log10(abs(value))), 0), 7)
    return f"{value:+.{places}f} %".replace("-", "−")


def relative_difference(value: float, reference: float) -> str:
    """The signed difference from a reference, in percent of it."""
    if not (math.isfinite(value) and math.isfinite(reference)) or reference == 0:
        return UNKNOWN
    return relative_change(value / reference - 1)


def in_sigmas(count: float) -> str:
    """`2.4 σ`, `496 σ`: tenths only where they matter."""
    return f"{count:.1f} σ" if count < 10 else f"{count:.0f} σ"


def list_in_words(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}" if items else ""


def number_ranges(values: Sequence[int | None]) -> str:
    """Numbers of points as ranges, `1 to 9 and 12`; those that are not known as `unknown`."""
    known, runs = sorted({v for v in values if v is not None}), list[list[int]]()
    for v in known:
        if runs and v == runs[-1][-1] + 1:
            runs[-1].append(v)
        else:
            runs.append([v])
    each = [t for r in runs for t in ([f"{r[0]} to {r[-1]}"] if len(r) > 2 else map(str, r))]
    return list_in_words([*each, *(["unknown"] if None in values else [])])


def count_with_noun(number: int, noun: str, plural: str = "") -> str:
    """`1 block`, `3 blocks`."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


def iso_date(value: date | None) -> str:
    """A date as 2024-05-31, which is read alike everywhere."""
    return "not given" if value is None else value.isoformat()


def _places(sigma: float) -> int:
    exponent = math.floor(math.log10(sigma))
    leading = round(sigma / 10**exponent, 1)
    # One figure of a sigma such as 1.4 would be off by a third, so it gets two.
    digits = 2 if leading < 2 else 1
    # A number holds no more than 16 digits, however small its sigma.
    return min(max(digits - 1 - exponent, 0), 12)


def short_number(value: float) -> str:
    """A round number as one would say it: 3, 110, 1.024."""
    return f"{value:.6g}".replace("-", "−") if math.isfinite(value) else UNKNOWN


def three_digits(value: float) -> str:
    """Three digits, and no exponent below a million: 1.02, 920, 2150."""
    if not math.isfinite(value):
        return UNKNOWN
    shown = f"{value:.3g}"
    return (f"{float(shown):.0f}" if "e+" in shown and abs(float(shown)) < LARGE else shown).replace("-", "−")


def _fixed_places(value: float, places: int) -> str:
    return f"{value:.{places}f}".replace("-", "−")


def with_nonbreaking_spaces(text: str) -> str:
    """The text with hard blanks between numbers and their units, so that no line breaks there."""
    return _UNIT.sub("\u00a0", text)


def probability_text(value: float) -> str:
    """To two digits, never rounded up, and never a certainty: 0.99 at most; `-` where there is none."""
    if not math.isfinite(value):
        return "-"
    return f"{math.floor(100 * min(value, CERTAIN) + 1e-9) / 100:.2f}"

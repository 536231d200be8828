"""Numbers in sentences."""

DIGITS = 3
LARGE = 1e6
"""From here on a number reads better with an exponent."""


def rounded(value: float) -> str:
    """Three digits, and no exponent below a million: 1.02, 920, 2150."""
    shown = f"{value:.{DIGITS}g}"
    return f"{float(shown):.0f}" if "e+" in shown and abs(float(shown)) < LARGE else shown

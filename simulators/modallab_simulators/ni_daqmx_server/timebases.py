"""Numbers by which devices say how they can be paced and triggered."""

MODES = [10178, 10123]
"""Finite and continuous."""
TRIGGERED = 0b1100
"""Reference and start triggers, as bits."""

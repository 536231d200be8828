"""The gap between twin and bench: how large, where, why, and how far it shrinks."""

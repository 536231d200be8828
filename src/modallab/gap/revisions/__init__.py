"""Revisions of a rig: a diagnosis put to work, and how the simulation came closer by it."""

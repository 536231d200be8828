"""Test campaigns: what is run on the bench, in which order, and what becomes of it."""

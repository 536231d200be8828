"""Sine generators on a serial line."""

"""TDMS files."""

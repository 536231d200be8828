"""Reads and writes the files of others, and campaigns as one file."""

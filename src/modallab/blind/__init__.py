"""Trials whose truth is sealed, and their score."""

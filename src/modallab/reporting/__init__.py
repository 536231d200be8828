"""Figures, pages and tables for people: step E of the paper."""

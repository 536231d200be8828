"""Figures, as matplotlib axes or SVG."""

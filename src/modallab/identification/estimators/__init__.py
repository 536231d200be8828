"""Estimators that give a search its first poles."""

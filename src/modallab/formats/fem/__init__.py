"""Modes of finite-element models: what CalculiX and Nastran write, and mass and stiffness matrices."""

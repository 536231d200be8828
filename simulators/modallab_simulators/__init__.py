"""Simulated devices, each a peer of a driver."""

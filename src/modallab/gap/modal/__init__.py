"""The gap of a structure that no beam describes: one modal model stands for the simulation, another for the bench."""

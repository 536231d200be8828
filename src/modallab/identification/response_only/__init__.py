"""Modal analysis of responses alone: the force is random, and was not measured."""

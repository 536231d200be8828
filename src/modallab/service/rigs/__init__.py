"""The rigs of a service: who controls each, and the run that is active."""

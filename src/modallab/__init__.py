"""modallab: drives a modal test bench, identifies its modal model, and diagnoses the sim-to-real gap."""

__version__ = "0.1.0"

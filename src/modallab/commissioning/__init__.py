"""Before a first test: the check of a rig, and calibration."""

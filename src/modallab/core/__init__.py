"""The frozen types every stage speaks, their units and their format versions."""

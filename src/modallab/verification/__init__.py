"""The model against the measurement: regenerated through the same block, compared by FRAC."""

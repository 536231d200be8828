"""Local nonlinear forces, fed back to the modes at every internal step."""

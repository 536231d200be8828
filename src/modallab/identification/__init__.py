"""Modal parameters from blocks and FRFs: step D of the paper."""

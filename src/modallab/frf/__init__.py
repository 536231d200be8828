"""Every frequency response function begins as scaled, mean-free blocks: steps A, B and C of the paper."""

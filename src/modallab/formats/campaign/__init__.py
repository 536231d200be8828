"""Campaign files: one HDF5 file with everything that was recorded."""

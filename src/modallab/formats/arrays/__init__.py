"""Files of arrays that have names: MATLAB, netCDF4; and sound files, which have none."""

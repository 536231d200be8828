"""SEP005 time series."""

"""The twin with free parameters, fitted to the data."""

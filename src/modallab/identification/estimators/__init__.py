"""The estimators: each module here is one, and declares itself as `ESTIMATOR`."""

"""Other simulations of the bench: what they predict of its records, compared with the bench and against the twin."""

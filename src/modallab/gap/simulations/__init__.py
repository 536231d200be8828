"""Other simulations of the bench: what they predict of its records, held against the bench and against the twin."""

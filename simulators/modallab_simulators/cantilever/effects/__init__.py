"""Effects the bench can be given: those of the catalogue, and others that are none of it."""

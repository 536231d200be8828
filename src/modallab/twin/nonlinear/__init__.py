"""Elements that do not answer in proportion: their laws, and the beam stepped in time with one of them."""

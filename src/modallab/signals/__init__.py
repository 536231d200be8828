"""From counts, volts or imported units to SI in the axes of the structure; hits, tones and full scale in them."""

"""Which point a hit has struck, by what the structure answers."""

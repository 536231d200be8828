"""Where a search for modes begins: peaks, bands, indicators, poles that hold, tones of a sine test."""

"""The terminal at the bench: a prompt to be read from two metres, tones, keys and a pedal."""

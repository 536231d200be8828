"""Faults of the chain that show in the samples themselves, whatever is known of ranges and converters."""

"""Which poles are modes, and how clearly."""

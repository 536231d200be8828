"""What each attribute answers, by the family it belongs to."""

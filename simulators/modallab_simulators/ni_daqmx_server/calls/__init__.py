"""What each call does: it takes the system and the request, and returns the fields of the answer."""

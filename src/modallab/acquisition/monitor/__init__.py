"""What watches the samples of a running bench: stream, limits, settled or not, live view."""

"""Which linear effects explain a gap: modal rows, one objective, selection by evidence."""

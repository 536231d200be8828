"""What a plan can tell apart, and what another campaign would read."""

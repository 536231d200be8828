"""What a plan can distinguish, and what another campaign would read."""

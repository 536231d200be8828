"""Jobs a worker can do: pure functions of a campaign and parameters."""

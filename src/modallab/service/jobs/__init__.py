"""Jobs of a campaign: ordered, followed, and their result files."""

"""What the service keeps in its database: campaigns, events, leases, who did what."""

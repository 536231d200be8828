"""The search for the effects that explain the gap."""

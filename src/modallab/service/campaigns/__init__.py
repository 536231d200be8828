"""The rules of a campaign: how runs begin, what blocks count, what is left after a crash."""

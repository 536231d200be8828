"""A structure known by its modal model: its FRFs at any pair, its response to a force, what a change makes of it."""

"""The process of a rig: its run, its commands, its latch, and the supervisor of its output."""

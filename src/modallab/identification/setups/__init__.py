"""The models of several set-ups of one test: compared, then joined into one."""

"""The tests a run can carry out: hits and their acceptance, sine bursts and their settling."""

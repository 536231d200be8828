"""A finite-element model beside a test: which modes are the same, and its parameters estimated from the test."""

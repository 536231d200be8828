"""The REST service's HTTP side: one file a resource; the rules stand in `modallab.service`."""

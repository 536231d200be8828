"""`modallab serve`: a small supervisor that starts, watches and ends the processes of the service."""

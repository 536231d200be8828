"""The client of the service; a package, so that what its tests share ends with the last of them."""

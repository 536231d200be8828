"""The page in a real browser; a package, so that its service ends with its last test."""

"""NPY files."""

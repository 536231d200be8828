"""The report's sections, one a file, in the order the reader meets them."""

"""The likelihood of the unfiltered blocks, and the search for its maximum."""

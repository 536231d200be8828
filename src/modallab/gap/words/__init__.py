"""Effects, their numbers and places, and the verdict of a diagnosis in words: once, for every door."""

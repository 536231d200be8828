"""The formats of recordings: each module here is one, and declares itself as `FORMAT`.

The command line asks all of them what they are, so that a module imports what is heavy inside its functions.
"""

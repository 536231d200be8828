"""What no effect of the catalogue explains, described: where it acts, what it behaves like, how far that closes it.

It is never claimed as a cause. What describes it is a learned element of the twin (`modallab.twin.learned`).
"""

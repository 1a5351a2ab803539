"""Two places of one coordinate: all motions that join them, proved by enclosures of the time over intervals of E.

In: a question. Out: connections with a proof that they are all, or the energies that are not decided.
Read ``proved_search.py`` first.
"""

"""Two places of coupled coordinates: a search for initial momenta, each verified by a motion.

In: a question. Out: connections and the ranges that were searched. ``flow.py`` runs starts with their
variations, ``shooting.py`` looks for zeros of the miss, ``searched.py`` starts the motions. Read ``shooting.py`` first.
"""

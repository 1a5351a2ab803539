"""Semiclassical levels: the energies of the tori whose actions are J = (n + μ/4) ħ (Einstein, Brillouin, Keller).

In: a solution, ħ and the greatest energy. Out: a ``Levels``: every level with its quantum numbers, kinds and Maslov
indices. Read ``level_search.py`` first (``levels``); ``ways.py`` says which indices belong to which kind of motion.
"""

"""Semiclassical levels: the energies of the tori whose actions are J = (n + μ/4) ħ (Einstein, Brillouin, Keller).

In: a solution, ħ and the greatest energy. Out: a ``Levels``: every level with its quantum numbers, kinds and Maslov
indices. Read ``level_search.py`` first (``levels``); ``maslov_indices.py`` has the indices of each kind of motion.
"""

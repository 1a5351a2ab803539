"""The energy–momentum map: which kinds of motion there are for which constants, and the curves that divide them.

In: a solution or a motion, and two of its constants. Out: an ``EnergyMomentumMap``: the kinds at any point, critical
curves, actions, and the monodromy of the tori round an isolated critical value. Read ``energy_momentum_map.py`` first;
``momentum_polynomial.py`` and ``isolation.py`` decide many points at once, ``exact_regions.py`` the doubtful ones.
"""

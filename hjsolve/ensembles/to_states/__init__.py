"""The inverse of ensembles: arrays of actions and angles in, arrays of states out.

In: J and θ of n orbits. Out: the constants of their tori (``newton_on_actions.py``: Newton's method on J(α) with the
integrals of the engine) and the states at the angles (``states_on_tori.py``), proved by the engine that maps states to
actions and angles. Read ``from_actions.py`` first.
"""

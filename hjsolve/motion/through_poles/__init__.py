"""Through poles: motions with p_φ = 0 go on where only the coordinates end, at an axis or at r = 0.

In: a motion that ends at the end of a domain, and an angle φ with p_φ = 0 whose M_φφ vanishes there. Out: the same
motion in coordinates continued through that end, expressed in the given ones.
Read ``continuation.py`` first, then ``continued_motion.py``.
"""

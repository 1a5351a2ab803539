"""Killing tensors K with d(K·dV) = 0: the linear algebra that decides in which webs a potential separates, exactly.

In: a potential in Cartesian coordinates. Out: a basis of its Killing tensors, for general and for special parameters.
Read ``killing_tensors.py`` first; ``numerical_rank.py`` counts the solutions a second time, by 60-digit numbers.
"""

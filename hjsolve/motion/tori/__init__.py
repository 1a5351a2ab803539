"""Tori: motions from their actions and angles instead of initial data.

In: a solution, actions and angles. Out: an ordinary ``Motion``. A search in doubles (``search.py``) finds every torus
that may have the actions, and Newton's method with the integrals of the motion itself makes its constants exact to the
digits asked (``polish.py``). The search decides only where Newton's method begins, never a result.
Read ``from_actions.py`` first.
"""

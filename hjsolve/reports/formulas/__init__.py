"""Formulas in reports: one layout of boxes, written as MathML, LaTeX or one line of text.

In: sympy expressions, and formulas inside sentences. Out: the layout, and its text in each format.
Read ``layout.py`` first, then ``from_sympy.py`` (the notation of the mechanics books).
"""

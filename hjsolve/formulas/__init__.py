"""Formulas: what a user writes, as text or as sympy, becomes exact sympy, through a whitelist; never ``eval``.

In: text, numbers of every kind, sympy expressions. Out: checked expressions over declared names.
Read ``read.py`` first (``parse`` and ``number``), then ``tokens.py`` and ``parser.py``;
``point_values.py`` gives the value of an expression at a point to 80 digits, for checks of input only.
"""

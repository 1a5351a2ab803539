"""Units: quantities of pint and astropy become numbers in the units of a system, and numbers become quantities.

In: a quantity, the unit it must have. Out: its number; or the quantity of a number. Read ``libraries.py`` first.
Neither library is imported here before a value of it has come or has been asked for.

Which unit a name of a system has is worked out in ``mechanics/units.py``.
"""

"""Tori from frequencies, ratios of frequencies and separatrices.

In: a solution, frequencies or a ratio, and constants that are held. Out: ordinary motions. A family of motions is
looked through in doubles by the engine of ensembles (``families.py``, ``scan.py``); what it brackets is made exact by
single motions with more digits (``found_tori.py``). Read ``found_tori.py`` first.
"""

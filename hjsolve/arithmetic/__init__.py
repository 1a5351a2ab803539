"""Arithmetic: one straight-line program, the tape, run in any arithmetic; no sympy here.

In: tapes made by ``hjsolve.lowering``. Out: values in doubles, double-doubles, many digits, intervals, balls, complex
disks, jets or exact fractions, each with what that arithmetic proves about its rounding.
Read ``tape.py`` first, then ``floats.py``; every other file is one more arithmetic or one transform of tapes and
arrays.
"""

"""The numeric half: no sympy here. From tapes and exact constants to classified motions and their integrals."""

"""q(t) of a motion: phases at given times, positions from phases, bounds on their errors, tables for many times."""

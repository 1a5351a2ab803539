"""Lambert's problem: all conics that join two places about a centre of attraction in a time.

In: a question, or arrays of places and times. Out: connections, or a table of them.
Read ``kernels/lambert.py`` first.
"""

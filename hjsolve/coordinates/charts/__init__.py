"""Charts: from a web to coordinates with names, and the system written in them.

In: a web. Out: x(u), h² and domains of its coordinates; the transformed system, certified by ``separate``.
Read ``charts.py`` first, then ``transform.py``.
"""

"""Sections of a report: from a system, a verdict, a solution, a motion, a scene or a cost to blocks of a document.

In: values of the library. Out: blocks, without any format.
Read ``system_and_verdict.py`` first, then ``solution.py`` and ``motion.py``.
"""

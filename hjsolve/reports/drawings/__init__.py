"""Drawings in reports: SVG text that follows the page's colours, with a title and a description in words.

In: a motion, its effective potentials, or a measured cost. Out: one drawing each.
Read ``svg.py`` first (axes, curves, marks), then ``motion_figures.py``.
"""

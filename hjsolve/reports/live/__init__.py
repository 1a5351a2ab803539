"""The live report: one HTML file whose motion moves, with sliders for the constants of the motion.

In: a motion with one separated coordinate that librates. Out: tables that a few lines of JavaScript read, and the page.
Read ``tables.py`` first (what is computed beforehand, and its bound); ``page.py`` puts them and the script beside it
into a report.
"""

"""The live report: one HTML file whose motion moves, with sliders for the constants of the motion and parameters.

In: a motion whose separated coordinates librate or rotate. Out: tables that some JavaScript reads, and the page.
Read ``tables.py`` first (what is computed beforehand, and how far the page may be off), then ``neighbours.py`` (the
series), ``ranges.py`` (how far the sliders reach) and ``page_numbers.py``, the twin of a script next to it; ``data.py``
and ``page.py`` put it all and the scripts next to them into a report.
"""

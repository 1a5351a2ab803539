"""Display: what a value says of itself, in a terminal and in a notebook.

In: any public value. Out: its text, at most twenty short lines made of its fields; a notebook's HTML is asked of
``hjsolve.reports.notebook`` when a notebook asks for it. Everything imports this room, and it imports nothing. Read
``shown.py`` first; ``progress.py`` is the bar on a terminal.
"""

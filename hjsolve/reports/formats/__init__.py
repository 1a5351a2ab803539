"""Formats of a report: HTML, Markdown, JSON, LaTeX and plain text, each written from the same document.

In: a ``Document``. Out: text of one file. Read ``block_writer.py`` first (the walk), then ``html.py``.
"""

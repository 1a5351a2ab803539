"""Reports: one document about a system and a motion, written as HTML, Markdown, JSON, text or LaTeX."""

from hjsolve.reports.write import SUFFIXES, report

__all__ = ["SUFFIXES", "report"]

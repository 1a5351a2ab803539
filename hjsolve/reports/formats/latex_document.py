"""A document as one LaTeX file, for pdflatex with ``amsmath``; drawings are described in words."""

from __future__ import annotations

import re
from unicodedata import decomposition, normalize

from hjsolve.reports.document import ArgumentStep, Document, Figure, Formula, Number, Section, Steps, Table, Text
from hjsolve.reports.formats.block_writer import BlockWriter, PieceWriter
from hjsolve.reports.formulas.latex import escape, latex_of
from hjsolve.reports.formulas.layout import Box, Grid
from hjsolve.reports.formulas.names import LATEX_SIGNS

_PREAMBLE = r"""\documentclass[11pt,a4paper]{article}
\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage{lmodern,amsmath,graphicx,booktabs,microtype}
\usepackage[margin=25mm]{geometry}
\allowdisplaybreaks
\begin{document}
"""
_LETTERS = {sign: f"${latex}$" for sign, latex in LATEX_SIGNS.items()} | {
    "½": r"\textonehalf{}", "²": r"\textsuperscript{2}", "ᵀ": r"\textsuperscript{T}", "ʰ": r"\textsuperscript{h}",
    "ᵢ": r"\textsubscript{i}", "ⱼ": r"\textsubscript{j}", "…": r"\dots{}", "·": r"$\cdot$", "–": "--", "µ": r"$\mu$",
    "§": r"\S{}", "∛": r"$\sqrt[3]{\ }$", "′": r"$'$", "ο": "o",
}  # fmt: skip
_SIGNS = {"yes": r"$\surd$ ", "no": r"$\times$ ", "open": "? "}


def tex(document: Document) -> str:
    """Write a document as LaTeX.

    Returns:
        A file that pdflatex takes.
    """
    subtitle = rf"\\ \texttt{{{escape(document.subtitle)}}}" if document.subtitle else ""
    answer = _SIGNS.get(document.verdict, "") + _WRITER.text(document.answer)
    head = rf"\section*{{{_plain(document.title)}{subtitle}}}" + "\n" + answer
    return _PREAMBLE + "\n\n".join([head, *map(_section, document.sections)]) + "\n\n\\end{document}\n"


def _section(section: Section) -> str:
    return "\n\n".join([rf"\subsection*{{{_plain(section.title)}}}", *map(_WRITER.block, section.blocks)])


class _LatexWriter(PieceWriter, BlockWriter[str]):
    def paragraph(self, text: Text) -> str:
        return self.text(text)

    def note(self, text: Text) -> str:
        return rf"\begin{{quote}}\small {self.text(text)}\end{{quote}}"

    def formula(self, formula: Formula) -> str:
        tag = rf"\tag*{{\footnotesize {_plain(formula.tag)}}}" if formula.tag else ""
        body = latex_of(formula.box)
        if isinstance(formula.box, Grid) and not formula.box.left:
            return f"\\begin{{equation*}}\n{body}{tag}\n\\end{{equation*}}"
        fit = r"\resizebox{\ifdim\width>0.8\linewidth 0.8\linewidth\else\width\fi}{!}"
        return f"\\begin{{equation*}}\n{fit}{{$\\displaystyle {body}$}}{tag}\n\\end{{equation*}}"

    def steps(self, steps: Steps) -> str:
        return "\\begin{enumerate}\n" + "\n".join(map(self._step, steps.items)) + "\n\\end{enumerate}"

    def _step(self, step: ArgumentStep) -> str:
        formula = "\n" + self.formula(step.formula) if step.formula else ""
        return rf"\item \textbf{{{_plain(step.title)}.}} {self.text(step.text)}{formula}"

    def table(self, table: Table) -> str:
        rows = " \\\\\n".join(" & ".join(map(self.text, row)) for row in table.rows)
        head = " & ".join(map(self.text, table.header))
        body = (
            rf"\begin{{tabular}}{{{'l' * len(table.header)}}}\toprule {head} \\\midrule"
            + f"\n{rows} \\\\\\bottomrule\\end{{tabular}}"
        )
        caption = rf"\par\smallskip {{\small {_plain(table.caption)}}}" if table.caption else ""
        shrink = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}"
        return rf"\begin{{center}}{shrink}{{{body}}}{caption}\end{{center}}"

    def figure(self, figure: Figure) -> str:
        return rf"\emph{{{_plain(figure.description)}}}"

    def figures(self, figures: tuple[Figure, ...]) -> str:
        return "\n\n".join(map(self.figure, figures))

    def words(self, text: str) -> str:
        return _plain(text)

    def mathematics(self, box: Box) -> str:
        return f"${latex_of(box)}$"

    def code(self, text: str) -> str:
        return rf"\texttt{{{_plain(text)}}}"

    def strong(self, text: str) -> str:
        return rf"\textbf{{{_plain(text)}}}"

    def number(self, number: Number) -> str:
        value, proof = self.digits(number.value), " (certified)" if number.certified else ""
        return (rf"${value} \pm {self.digits(number.error)}$" if number.error else f"${value}$") + proof

    def digits(self, text: str) -> str:
        mantissa, _, exponent = text.partition("e")
        if mantissa in {"∞", "−∞"}:
            return mantissa.replace("∞", r"\infty").replace("−", "-")
        return rf"{mantissa}\times 10^{{{exponent}}}" if exponent else mantissa


def _plain(text: str) -> str:
    """Prose with every letter that pdflatex does not know written out."""
    pieces = re.findall(r".\u0307?", normalize("NFC", escape(text)), flags=re.DOTALL)
    return "".join(map(_letter, pieces))


def _letter(letter: str) -> str:
    """One letter, perhaps with a dot over it; raised and lowered ones by what they are made of."""
    dotted = letter if letter.endswith("\u0307") else normalize("NFD", letter)
    if dotted.endswith("\u0307") and len(dotted) == 2:
        return rf"$\dot{{{_LETTERS.get(dotted[0], dotted[0]).strip('$')}}}$"
    if letter in _LETTERS:
        return _LETTERS[letter]
    kind, _, parts = decomposition(letter).partition(" ")
    plain = "".join(chr(int(part, 16)) for part in parts.split()) if kind.startswith("<") else ""
    match kind:
        case "<sub>":
            return rf"\textsubscript{{{_plain(plain)}}}"
        case "<super>":
            return rf"\textsuperscript{{{_plain(plain)}}}"
        case "<fraction>":
            top, _, bottom = plain.partition("⁄")
            return rf"$\tfrac{{{top}}}{{{bottom}}}$"
    return letter


_WRITER = _LatexWriter()

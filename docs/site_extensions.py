"""What the site needs besides Sphinx's own extensions: formulas as MathML, and outputs under the code.

Formulas are typeset when the site is built, so that a page fetches no script from the net. The pages of this folder put
what a ``print`` shows in a comment after it, which reads well in the source; on the site it stands in a block below.
"""

from __future__ import annotations

import re
from html import escape

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_BLOCK = re.compile(r"^```python\n(.*?)^```\n", flags=re.DOTALL | re.MULTILINE)
_PRINTED = re.compile(r"^(.*print\(.*\))  # (.+)$", flags=re.MULTILINE)


def with_outputs_below(source: str) -> str:
    """Return a page with the outputs of its Python in blocks under the code.

    Args:
        source: the Markdown of a page.

    Returns:
        The page; a block whose prints have no comments is left as it is.
    """

    def moved(match: re.Match[str]) -> str:
        code = match[1]
        lines = [found[2] for found in _PRINTED.finditer(code)]
        if not lines:
            return match[0]
        return f"```python\n{_PRINTED.sub(lambda m: m[1], code)}```\n\n```{{code-block}} text\n:class: output\n\n" + (
            "\n".join(lines) + "\n```\n"
        )

    return _BLOCK.sub(moved, source)


def _mathml(latex: str, display: str) -> str:
    return convert(latex.strip(), display=display)


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(f'<span class="math">{_mathml(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.math_block) -> None:
    number = f'<span class="eqno">({escape(str(node["number"]))})</span>' if node.get("number") else ""
    anchor = f' id="equation-{node["label"]}"' if node.get("label") else ""
    parts = [part for part in node.astext().split("\n\n") if part.strip()]
    formulas = "".join(_mathml(part, "block") for part in parts)
    self.body.append(f'<div class="math"{anchor}>{number}{formulas}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Register the renderer and the hook.

    Args:
        app: what builds the site.
    """
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.connect("source-read", _outputs)


def _outputs(_app: Sphinx, _name: str, source: list[str]) -> None:
    source[0] = with_outputs_below(source[0])

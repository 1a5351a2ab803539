"""What the site needs besides Sphinx's own extensions: formulas as MathML, outputs under the code, tidy API pages.

Formulas are typeset when the site is built, so that a page fetches no script from the net. On some pages the output of
a ``print`` stands in a comment after it, which reads well in the source; on the site it is a block below the code.
"""

from __future__ import annotations

import re
from html import escape

from docutils import nodes
from latex2mathml.converter import convert
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.domains.python import PyObject
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode
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


_LOOSE_SLASH, _LOOSE_SIGN = "<mo>&#x0002F;</mo>", "<mo>&#x02212;</mo>"
_AFTER = ("<mo>&#x0003D;</mo>", "<mo>&#x0002C;</mo>", "<mo>&#x0003C;</mo>", "<mo>&#x0003E;</mo>")


def _mathml(latex: str, display: str) -> str:
    """Convert a formula; a quotient a/b and the sign of a term are set close, as in print."""
    set_ = convert(latex.strip(), display=display).replace(_LOOSE_SLASH, '<mo lspace="0" rspace="0">/</mo>')
    for before in _AFTER:
        set_ = set_.replace(before + _LOOSE_SIGN, f'{before}<mo form="prefix">&#x02212;</mo>')
    return set_.replace("<mi>&#x02202;</mi>", '<mo lspace="0" rspace="0">&#x02202;</mo>')


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(f'<span class="math">{_mathml(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.math_block) -> None:
    number = f'<span class="eqno">({escape(str(node["number"]))})</span>' if node.get("number") else ""
    anchor = f' id="equation-{node["label"]}"' if node.get("label") else ""
    parts = [part for part in node.astext().split("\n\n") if part.strip()]
    formulas = "".join(_mathml(part, "block") for part in parts)
    self.body.append(f'<div class="math"{anchor}><div class="formula">{formulas}</div>{number}</div>\n')
    raise nodes.SkipNode


INNER = {
    "Batch": {"columns", "layout"},
    "Chart": {"outer"},
    "EnergyMomentumMap": {"solution", "constants", "coordinates"},
    "FamilyCurve": {"errors", "placing"},
    "Motion": {"separated", "states", "given", "again"},
    "Regime": {"conditions", "regions"},
    "Scene": {"table"},
    "State": {"errors", "placing"},
    "Wavefronts": {"maker"},
}
"""Fields of public classes that only hjsolve itself reads: they are not on the site."""
SEE_ALSO = {
    "System": "separate solve parameter change_coordinates",
    "parameter": "System",
    "from_hamiltonian": "solve gyroscopic_modes",
    "separate": "solve find_coordinates is_integral",
    "Separation": "separate Obstruction solve",
    "Obstruction": "separate find_coordinates Undecided",
    "Undecided": "separate Obstruction",
    "find_coordinates": "separate solve normal_modes",
    "normal_modes": "find_coordinates gyroscopic_modes",
    "gyroscopic_modes": "normal_modes from_hamiltonian",
    "solve": "separate closed_forms Solution.motion ensemble",
    "Solution": "solve Motion closed_forms verify",
    "closed_forms": "solve RegimeForms energy_momentum_map",
    "RegimeForms": "closed_forms Regime",
    "verify": "solve canonical is_integral",
    "canonical": "verify poisson_bracket change_coordinates",
    "change_coordinates": "System find_coordinates canonical",
    "poisson_bracket": "is_integral canonical",
    "is_integral": "poisson_bracket verify",
    "Motion": "Solution.motion State ensemble report",
    "State": "Motion.at Estimate",
    "Estimate": "EstimateArray Measured",
    "EstimateArray": "Estimate",
    "Measured": "Estimate Motion.to_units",
    "ensemble": "Batch sweep Solution.motion",
    "Batch": "ensemble Status sweep",
    "ensemble_derivatives": "ensemble Motion.derivatives",
    "levels": "Solution.motion energy_momentum_map",
    "separatrix": "Solution.torus Solution.separatrices",
    "impact": "change_coordinates contact Scene",
    "contact": "constraint_forces impact Scene",
    "constraint_forces": "System contact",
    "involution": "is_integral poisson_bracket",
    "action_integral": "jacobi_metric verify",
    "loop_integral": "canonical is_integral",
    "jacobi_metric": "solve verify",
    "Status": "Batch",
    "sweep": "ensemble Scene SweepResult",
    "SweepResult": "sweep",
    "Scene": "sweep report cost",
    "report": "figures Motion.plot cost",
    "figures": "report Motion.plot",
    "cost": "Cost report",
    "Cost": "cost",
    "energy_momentum_map": "EnergyMomentumMap Motion wavefronts",
    "EnergyMomentumMap": "energy_momentum_map",
    "wavefronts": "Wavefronts Motion.characteristic_function",
    "Wavefronts": "wavefronts FamilyCurve",
}
"""Public name → what a reader of its page may want next."""


def _hidden(_app: Sphinx, what: str, name: str, _thing: object, skip: bool | None, _options: object) -> bool | None:
    """Hide inner fields; ``name`` is that of the member alone, so its class is not asked."""
    return True if what == "class" and name in _INNER_ALONE else skip


_INNER_ALONE = {"again", "layout", "maker", "outer", "placing", "regions", "separated", "states"}
_HEADING = re.compile(r"^(\w[\w ]*):$")
_FIELD = re.compile(r"^    ([\w, ]+): (.*)$")


def _tidied(_app: Sphinx, what: str, name: str, _thing: object, _options: object, lines: list[str]) -> None:
    """Prepare a docstring for napoleon, which takes any text before a colon for a type.

    Fields described together (``x, y: …``) become one field each, inner fields are left out.
    """
    if what in ("attribute", "property") and lines:
        lines[0] = _dashed(lines[0])
    inner = INNER.get(name.rpartition(".")[2], set()) if what == "class" else set()
    section, kept = "", []
    names: list[str] = []
    field: list[str] = []

    def flush() -> None:
        for own in names:
            kept.append(f"    {own}: {field[0]}")
            kept.extend(field[1:])
        names.clear()
        field.clear()

    for line in lines:
        if heading := _HEADING.match(line):
            flush()
            section, fresh = heading[1], True
            kept += [line] if not kept or not kept[-1].strip() else ["", line]
        elif section in ("Attributes", "Args") and (found := _FIELD.match(line)):
            flush()
            every = found[1].split(", ")
            names[:] = [own for own in every if section == "Args" or own not in inner]
            field[:] = [found[2]]
        elif field and (line.startswith("     ") or not line.strip()):
            field.append(line)  # of a field that is left out as well
        else:
            flush()
            if section in ("Returns", "Yields") and line.strip() and fresh:
                line, fresh = _dashed(line), False
            kept.append(line)
    flush()
    if what in ("class", "function") and (others := SEE_ALSO.get(name.rpartition(".")[2])):
        links = (f":{_role(other)}:`~hjsolve.{other}`" for other in others.split())
        kept += ["", "See Also:", f"    {', '.join(links)}"]
    lines[:] = kept


def _role(name: str) -> str:
    return "class" if name[0].isupper() and "." not in name else "meth" if "." in name else "func"


def _dashed(line: str) -> str:
    return re.sub(r":(?= |$)", " —", line, count=1)


def _by_last_name(app: Sphinx, env: BuildEnvironment, node: nodes.Element, text: nodes.Element) -> nodes.Element | None:
    """Resolve a class that is imported for type checkers only: its annotation has no module."""
    wanted = node.get("reftarget", "")
    if node.get("refdomain") != "py" or not wanted.isidentifier():
        return None
    known = {whole: thing for whole, thing in env.domains.python_domain.objects.items() if not thing.aliased}
    found = [(whole, thing) for whole, thing in known.items() if whole.rpartition(".")[2] == wanted]
    if len(found) != 1:
        return None
    (whole, thing), start = found[0], node.get("refdoc", env.docname)
    return make_refnode(app.builder, start, thing.docname, thing.node_id, text, whole)


_LONG_TYPES = {
    "collections.abc.": "",
    "ndarray[tuple[Any, ...], dtype[float64]] | ndarray[tuple[Any, ...], dtype[object_]]": "ndarray",
    "ndarray[tuple[Any, ...], dtype[float64]]": "ndarray",
    "ndarray[tuple[Any, ...], dtype[object_]]": "ndarray",
}


def _short_types(_app: Sphinx, tree: nodes.document, _name: str) -> None:
    """Write types as one says them: ``Mapping``, ``ndarray``."""
    for signature in (*tree.findall(addnodes.desc_signature), *tree.findall(nodes.field_list)):
        for text in list(signature.findall(nodes.Text)):
            short = str(text)
            for long, better in _LONG_TYPES.items():
                short = short.replace(long, better)
            if short != str(text):
                text.parent.replace(text, nodes.Text(short))
    for returned in tree.findall(addnodes.desc_returns):
        if returned.astext() in _LONG_TYPES:
            returned.children = [nodes.Text(_LONG_TYPES[returned.astext()])]


def setup(app: Sphinx) -> None:
    """Register the renderer and the hooks.

    Args:
        app: what builds the site.
    """
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.connect("source-read", _outputs)
    app.connect("autodoc-process-docstring", _tidied, priority=100)
    app.connect("autodoc-skip-member", _hidden)
    app.connect("missing-reference", _by_last_name)
    app.connect("doctree-resolved", _short_types)
    for field in PyObject.doc_field_types:
        if field.name == "variable":
            field.label = "Attributes"


def _outputs(_app: Sphinx, _name: str, source: list[str]) -> None:
    source[0] = with_outputs_below(source[0])

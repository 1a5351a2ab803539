"""Recognising the Liouville form T = Σ Rᵢpᵢ²/(2Σf), V = Σv/Σf, and finding its functions (Greenwood (5-125), (5-126)).

With gⁱⁱ = Rᵢ/σ, σ = Σf: every ratio gⁱⁱ/gʲʲ = Rᵢ/Rⱼ must be a product of a function of qᵢ and one of qⱼ, and σ and σV
must be sums of functions of one coordinate each. In two dimensions this is the same as the Stäckel form up to a
rescaling; in more it is less.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.readable import printed_length, shortest_form, variants
from hjsolve.algebra.reader import Reader
from hjsolve.separation.forms.base_points import find_base_points
from hjsolve.separation.verdicts import Liouville
from hjsolve.separation.zero_test.interval_evaluation import Region


def recognise(
    reader: Reader,
    names: Sequence[str],
    symbols: Sequence[sp.Symbol],
    metric: Sequence[Element],
    potential: Element,
    region: Region,
) -> Liouville | None:
    """Return the functions f, R, v of an orthogonal system, or None when it is not of Liouville form.

    Args:
        names, symbols: of the essential coordinates.
        metric: gᵃᵃ, one element a coordinate.
        potential: V or V_eff.
        region: where the sign of σ = Σ f is looked up, so that it comes out positive.
    """
    ratios = _separate_ratios(reader, symbols, metric)
    if ratios is None:
        return None
    σ = reader.field.cancelled(ratios[0] / metric[0])
    if not _is_additive(reader, σ, symbols):
        return None
    if not any(σ.depends_on(q) for q in symbols):
        ratios, σ = [x / σ for x in ratios], reader.field.one
    σV = reader.field.cancelled(reader.field.factored(σ) * potential)
    if not _is_additive(reader, σV, symbols):
        return None
    if _sign_somewhere(reader, σ, region) < 0:
        ratios, σ, σV = [-x for x in ratios], -σ, -σV
    f, v = split_sum(reader, σ, symbols), split_sum(reader, σV, symbols)
    if f is None or v is None:
        return None
    return Liouville(
        tuple(names),
        tuple(shortest_form(reader, x) for x in f),
        tuple(shortest_form(reader, x) for x in ratios),
        tuple(shortest_form(reader, x) for x in v),
    )


def _separate_ratios(reader: Reader, symbols: Sequence[sp.Symbol], metric: Sequence[Element]) -> list[Element] | None:
    """R_i with R_i/R_j = gⁱⁱ/gʲʲ, R_i a function of q_i alone; constants go to the first coordinates."""
    last = len(symbols) - 1
    found: list[Element] = []
    r_last = reader.field.one
    for i in range(last):
        ratio = reader.field.factored(reader.field.cancelled(metric[i] / metric[last]))
        parts = split_product(reader, ratio, symbols, i, last)
        if parts is None:
            return None
        if i == 0:
            r_last = parts[1] ** -1
        found.append(ratio * r_last)
    found.append(r_last)
    for i, x in enumerate(found):
        others = [q for k, q in enumerate(symbols) if k != i]
        if any(not reader.diff(x, q).is_zero for q in others):
            return None
    return [_without(reader, x, [q for k, q in enumerate(symbols) if k != i]) for i, x in enumerate(found)]


def split_product(
    reader: Reader, x: Element, symbols: Sequence[sp.Symbol], i: int, j: int
) -> tuple[Element, Element] | None:
    """Write x = a(q_i)·b(q_j), constants in a; by its factors where they separate, else at a base point.

    None if it is not a product.

    Args:
        x: what is to be split.
        symbols: essential coordinates.
        i, j: positions of the two coordinates that x depends on.
    """
    field = reader.field
    log_slope = reader.log_diff(x, symbols[i])
    if any(not reader.diff(log_slope, q).is_zero for k, q in enumerate(symbols) if k != i):
        return None
    a: dict[int, int] = {}
    b: dict[int, int] = {}
    for base, e in x.factors.items():
        factor = Element(field, Fraction(1), {0: 1}, {base: e})
        holds = [k for k, q in enumerate(symbols) if factor.depends_on(q)]
        if not set(holds) <= {j} and not set(holds) <= {i}:
            return _split_at_base_point(reader, x, symbols, j)
        (b if holds == [j] else a)[base] = e
    return Element(field, x.coefficient, x.numerator, a), Element(field, Fraction(1), {0: 1}, b)


def _split_at_base_point(
    reader: Reader, x: Element, symbols: Sequence[sp.Symbol], j: int
) -> tuple[Element, Element] | None:
    for point in find_base_points(reader, symbols):
        try:
            of_j = point.keep(x, {j}) / point.keep(x, set())
            return x / of_j, of_j
        except ZeroDivisionError:
            continue
    return None


def _is_additive(reader: Reader, x: Element, symbols: Sequence[sp.Symbol]) -> bool:
    """Return whether all mixed derivatives vanish."""
    slopes = [reader.diff(x, q) for q in symbols]
    return all(reader.diff(slopes[i], symbols[j]).is_zero for j in range(len(symbols)) for i in range(j))


def split_sum(reader: Reader, x: Element, symbols: Sequence[sp.Symbol]) -> list[Element] | None:
    """Write x = Σ x_i(q_i): term by term where the terms separate, else at a base point; constants go to the first.

    Args:
        x: what is to be split.
        symbols: essential coordinates.
    """
    x = reader.field.expanded(x)
    by_terms = [parts for y in variants(reader, x) if (parts := _split_terms(reader, y, symbols)) is not None]
    if by_terms:
        return min(by_terms, key=lambda parts: sum(map(printed_length, parts)))
    for point in find_base_points(reader, symbols):
        try:
            constant = point.keep(x, set())
            parts = [point.keep(x, {i}) - constant for i in range(len(symbols))]
            parts[0] = parts[0] + constant
            return [reader.field.cancelled(part) for part in parts]
        except ZeroDivisionError:
            continue
    return None


def _split_terms(reader: Reader, x: Element, symbols: Sequence[sp.Symbol]) -> list[Element] | None:
    field = reader.field
    parts = [field.zero] * len(symbols)
    constants = []
    for m, c in x.numerator.items():
        term = field.monomial(m, x.coefficient * c, x.factors)
        holds = [i for i, q in enumerate(symbols) if term.depends_on(q)]
        if len(holds) > 1:
            return None
        if holds:
            parts[holds[0]] = parts[holds[0]] + term
        else:
            constants.append(term)
    home = next((i for i, part in enumerate(parts) if not part.is_zero), 0)
    parts[home] = field.total([parts[home], *constants])
    return parts


def _without(reader: Reader, x: Element, others: Sequence[sp.Symbol]) -> Element:
    """Return the same function written without symbols it does not really depend on."""
    if not any(x.depends_on(q) for q in others):
        return x
    for point in find_base_points(reader, others):
        try:
            return point.keep(x, set())
        except ZeroDivisionError:
            continue
    return x


def _sign_somewhere(reader: Reader, x: Element, region: Region) -> int:
    """Return the sign at the first point of the region where it is certain; +1 if nowhere."""
    expression = reader.write(x)
    for point in region.points(expression):
        try:
            lower, upper = enclose(expression, point)
        except NoEnclosureError:
            continue
        if lower > 0 or upper < 0:
            return 1 if lower > 0 else -1
    return 1

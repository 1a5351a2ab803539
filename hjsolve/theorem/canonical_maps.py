"""canonical(): is this map (q, p) → (Q, P) canonical, and which functions generate it?

    (Q_j, Q_k) = (P_j, P_k) = 0,  (Q_j, P_k) = μ δ_jk  (6-215), (6-277);   MᵀZM = μZ (6-334)
    μ Σ p dq − Σ P dQ = dψ at fixed time (6-23), (6-266);   K = μH + ∂ψ/∂t + Σ P ∂Q/∂t (6-26)

The three conditions are equivalent; the brackets are proved, and ψ is then integrated and verified.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.integration import closed_form_potential
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.reader import Reader
from hjsolve.arguments import ascii_name, described, with_known_names
from hjsolve.display.shown import Shown, listed_names
from hjsolve.errors import InvalidInputError, required
from hjsolve.mechanics.brackets import bracket
from hjsolve.mechanics.coordinates_and_parameters import read_coordinates
from hjsolve.precision import one_at_a_time
from hjsolve.separation import Undecided
from hjsolve.separation.zero_test.zero_test import Zero
from hjsolve.theorem.answers import Flaw
from hjsolve.theorem.generating_functions import Generating, functions_of, map_of
from hjsolve.theorem.integrals import short
from hjsolve.theorem.phase_space import BUDGET, PhaseSpace, Variables
from hjsolve.theorem.reading import new_names, read_formula

TIME = sp.Symbol("t", real=True)
_PLACES = tuple(map(sp.Rational, ("1", "1/2", "0", "2", "-1")))
"""Values of all variables at once where a valence, which is a constant, is evaluated."""
_SINGULAR = (sp.nan, sp.zoo, sp.oo, -sp.oo)


@dataclass(frozen=True, repr=False)
class CanonicalMap(Shown):
    """A map (q, p) → (Q, P) that is proved to be canonical.

    Attributes:
        map: name of a new variable → its formula in (q, p, t): the coordinates Q, then the momenta P.
        valence: μ, with (Q_j, P_k) = μ δ_jk; 1 for a map that keeps the brackets.
        jacobian: M = ∂(Q, P)/∂(q, p), shape (2n, 2n), with MᵀZM = μZ.
        psi: ψ(q, p, t) with μ Σ p dq − Σ P dQ = dψ at fixed time, up to a function of the time; an unevaluated
            integral where no closed form was found.
        added_hamiltonian: K − μH = ∂ψ/∂t + Σ P ∂Q/∂t (6-26), in (q, p, t); ∂F/∂t of a generating function that was
            given, else up to a function of the time.
        generating: ``F1`` … ``F4`` → the generating function in its own variables, each verified by its equations
            (6-18), (6-46), (6-52), (6-57).
        why_not: ``F1`` … ``F4`` → why there is none here.
        where: ``F1`` … ``F4`` → the part of phase space on which it was verified, in words; empty: everywhere.
        hamiltonian: K in (q, p, t) where H was given, else None.
        variables: names of the old variables, coordinates first: the columns of ``jacobian``.
    """

    map: Mapping[str, sp.Expr]
    valence: sp.Expr
    jacobian: sp.ImmutableMatrix
    psi: sp.Expr
    added_hamiltonian: sp.Expr
    generating: Mapping[str, sp.Expr]
    why_not: Mapping[str, str]
    where: Mapping[str, str]
    hamiltonian: sp.Expr | None = None
    variables: tuple[str, ...] = ()

    def lagrange_bracket(self, u: str, v: str) -> sp.Expr:
        """Return the Lagrange bracket [u, v] = Σ ∂Q/∂u ∂P/∂v − ∂P/∂u ∂Q/∂v (6-206) of two old variables.

        It is μ for a coordinate and its momentum, −μ the other way round, and 0 for any other two (6-207).

        Args:
            u, v: names of old variables.

        Raises:
            InvalidInputError: not the name of an old variable.
        """
        for name in (u, v):
            if name not in self.variables:
                raise InvalidInputError(f"lagrange_bracket: {name} is not one of {', '.join(self.variables)}")
        M, n = self.jacobian, len(self.variables) // 2
        i, j = self.variables.index(u), self.variables.index(v)
        return sp.simplify(sp.Add(*(M[k, i] * M[n + k, j] - M[n + k, i] * M[k, j] for k in range(n))))

    def __str__(self) -> str:
        """Return the statement in one sentence."""
        found = f"; generating functions {listed_names(self.generating)}" if self.generating else ""
        return f"Canonical with valence {self.valence}{found}."


@with_known_names('canonical({"Q": "q*cos(a) - p*sin(a)", "P": "q*sin(a) + p*cos(a)"}, parameters="a")')
@one_at_a_time
def canonical(
    map: Mapping[str, object] | None = None,  # noqa: A002 - the field's word
    *,
    coordinates: Mapping[str, str] | None = None,
    domains: Mapping[str, str] | None = None,
    parameters: str | Sequence[str] | Mapping[str, str] = (),
    hamiltonian: object = None,
    generating: Mapping[str, object] | None = None,
    new: Mapping[str, str] | None = None,
    budget: float = BUDGET,
) -> CanonicalMap | Flaw | Undecided:
    """Decide whether a map of canonical variables is canonical, and find the functions that generate it.

    Args:
        map: new variable → formula in the old ones and t, the coordinates first, then their momenta in the same order:
            ``{"Q": "sqrt(2*q)*cos(p)", "P": "sqrt(2*q)*sin(p)"}``. A text or a sympy expression.
        coordinates: old coordinate → its momentum; by default ``{"q": "p"}``, of n pairs ``{"q1": "p1", …}``.
        domains: old variable → where it lies, such as ``{"q": "0 < q"}``; any real number by default.
        parameters: names of constants in the formulas; or name → domain, ``{"m": "0 < m"}``.
        hamiltonian: H(q, p, t), where K is wanted.
        generating: in place of ``map`` one generating function with its kind, ``{"F2": "P*q**2"}``, in variables of its
            kind: F1(q, Q), F2(q, P), F3(p, Q), F4(p, P), each with t; the map is solved from it.
        new: with ``generating``, new coordinate → its momentum; by default ``{"Q": "P"}`` or ``{"Q1": "P1", …}``.
        budget: seconds for each zero test.

    Returns:
        ``CanonicalMap``: proved. ``Flaw``: a bracket is wrong, with a witness. ``Undecided``: neither was proved.

    Raises:
        InvalidInputError: map and generating function or neither, a map of other than 2n formulas, or a generating
            function that no map could be solved from.
        ExpressionError: a formula cannot be read.

    Example:
        >>> import hjsolve
        >>> answer = hjsolve.canonical({"Q": "atan(q/p)", "P": "(q**2 + p**2)/2"}, domains={"p": "0 < p"})
        >>> answer.valence, answer.generating["F1"]
        (1, q**2/(2*tan(Q)))

    References:
        Greenwood, Classical Dynamics (1977), (6-14)–(6-26), (6-45)–(6-60), (6-215), (6-266)–(6-277), (6-334).
    """
    if (map is None) == (generating is None):
        raise InvalidInputError("canonical: give a map or generating={…}, one of them")
    seconds = arguments.seconds(budget, "budget")
    count = len(new or coordinates or "1") if map is None else len(map) // 2
    space = read_variables(coordinates or _numbered("q", "p", count), domains or {}, parameters)
    if map is None:
        formulas, ψ = map_of(required(generating), new or _numbered("Q", "P", len(space.pairs)), space, seconds)
    else:
        formulas, ψ = _formulas(map, space), None
    H = None if hamiltonian is None else read_formula(hamiltonian, space.symbols, "hamiltonian")
    return _decide(space, formulas, ψ, H, seconds)


def _numbered(q: str, p: str, count: int) -> dict[str, str]:
    return {q: p} if count < 2 else {f"{q}{i}": f"{p}{i}" for i in range(1, count + 1)}


def _formulas(given: Mapping[str, object], space: PhaseSpace) -> dict[str, sp.Expr]:
    if len(given) != 2 * len(space.pairs):
        raise InvalidInputError(
            f"map: {len(space.pairs)} coordinates and as many momenta are needed, in this order; {len(given)} formulas "
            "are given"
        )
    if taken := [name for name in given if name in space.symbols]:
        raise InvalidInputError(f"map: {taken[0]} is the name of an old variable or a constant; choose another name")
    return {name: read_formula(formula, space.symbols, f"map.{name}") for name, formula in given.items()}


def _decide(
    space: PhaseSpace, formulas: Mapping[str, sp.Expr], ψ: sp.Expr | None, H: sp.Expr | None, seconds: float
) -> CanonicalMap | Flaw | Undecided:
    names, n = list(formulas), len(space.pairs)
    Q, P = list(formulas.values())[:n], list(formulas.values())[n:]
    μ = short(bracket(Q[0], P[0], space.pairs), space)
    if isinstance(space.vanishes(μ, seconds), Zero):
        return Flaw("valence", f"({names[0]}, {names[n]}) vanishes: the new variables are not independent", sp.S.Zero)
    for x in [s for pair in space.pairs for s in pair] + [space.time]:
        what = f"({names[0]}, {names[n]}) is not a constant, its derivative by {x.name} = 0 fails"
        if (wrong := space.proved_zero(sp.diff(μ, x), "valence", what, seconds)) is not None:
            return wrong
    μ = _without_variables(space, μ, seconds)
    for left in range(2 * n):
        for right in range(left + 1, 2 * n):
            ought = μ if right == left + n else sp.S.Zero
            value = bracket([*Q, *P][left], [*Q, *P][right], space.pairs)
            what = f"({names[left]}, {names[right]}) = {ought} fails"
            if (wrong := space.proved_zero(value - ought, "brackets", what, seconds)) is not None:
                return wrong
    if ψ is None:
        ψ = _potential(space, [μ * p - _sum(P, Q, q) for q, p in space.pairs], [-_sum(P, Q, p) for _, p in space.pairs])
    added = short(sp.diff(ψ, space.time) + _sum(P, Q, space.time), space)
    variables = [q for q, _ in space.pairs] + [p for _, p in space.pairs]
    found = functions_of(Generating(space, dict(formulas), μ, ψ), seconds)
    return CanonicalMap(
        dict(formulas), μ, sp.ImmutableMatrix([*Q, *P]).jacobian(variables).as_immutable(), ψ, added,
        found.functions, found.why_not, found.where, None if H is None else short(μ * H + added, space),
        tuple(x.name for x in variables),
    )  # fmt: skip


def _without_variables(space: PhaseSpace, μ: sp.Expr, seconds: float) -> sp.Expr:
    """Return a valence, which is a constant, in the parameters alone."""
    variables = {x for pair in space.pairs for x in pair} | {space.time}
    for value in _PLACES if μ.free_symbols & variables else ():
        found = short(μ.subs(dict.fromkeys(variables, value)), space)
        if not found.has(*variables, *_SINGULAR) and isinstance(space.vanishes(μ - found, seconds), Zero):
            return found
    return μ


def _sum(P: Sequence[sp.Expr], Q: Sequence[sp.Expr], x: sp.Symbol) -> sp.Expr:
    return sp.Add(*(b * sp.diff(a, x) for a, b in zip(Q, P, strict=True)))


def _potential(space: PhaseSpace, by_q: list[sp.Expr], by_p: list[sp.Expr]) -> sp.Expr:
    """ψ of a form that is closed, since the brackets are right; over q first, or over p first, as it can be done."""
    q, p = [q for q, _ in space.pairs], [p for _, p in space.pairs]
    orders = [([*q, *p], [*by_q, *by_p]), ([*p, *q], [*by_p, *by_q])]
    found = list[sp.Expr]()
    for symbols, form in orders:
        try:
            reader = Reader(form, dict(space.bounds), Budget.processor_seconds(BUDGET))
            found.append(closed_form_potential(reader, symbols, [reader.element(x) for x in form]))
        except (WorkLimitError, ZeroDivisionError):
            continue
    if not found:
        steps = [(x, a) for x, a in zip(orders[0][0], orders[0][1], strict=True) if a != 0]
        return sp.Add(*(sp.Integral(a, x) for x, a in steps[:1]))
    return min(found, key=lambda ψ: (ψ.has(sp.Integral), sp.count_ops(ψ)))


def read_variables(pairs: object, domains: Mapping[str, str], parameters: object) -> PhaseSpace:
    """Return the phase space of variables that a user names.

    Args:
        pairs: coordinate → its momentum.
        domains: variable → domain; the others are any real numbers.
        parameters: names, or name → domain; empty for none.

    Raises:
        InvalidInputError: no pairs, a name twice, or the domain of what is not a variable.
    """
    if not isinstance(pairs, Mapping) or not pairs:
        raise InvalidInputError(f'coordinates: pairs such as {{"q": "p"}} are needed, not {described(pairs)}')
    if domain := next((p for p in map(str, pairs.values()) if "<" in p or ">" in p), None):
        raise InvalidInputError(
            f'coordinates: the momentum of each is needed, such as {{"q": "p"}}; "{domain[:40]}" belongs in domains'
        )
    momenta = [ascii_name(str(p)) for p in pairs.values()]
    names = [ascii_name(str(q)) for q in pairs]
    if len({*names, *momenta, "t"}) != 2 * len(names) + 1:
        raise InvalidInputError("coordinates: a name is used for two variables, or for the time t")
    if others := set(domains) - {*names, *momenta}:
        raise InvalidInputError(f"domains: {sorted(others)[0]} is not one of {', '.join([*names, *momenta])}")
    declared = [read_coordinates({name: domains.get(name, "line")}, ())[0] for name in [*names, *momenta]]
    own = {c.name: c for c in declared}
    coordinates = tuple(replace(own[q], momentum=own[p].symbol) for q, p in zip(names, momenta, strict=True))
    symbols = {"t": TIME} | {c.name: c.symbol for c in declared}
    constants, ranges = new_names(parameters, symbols, "parameters") if parameters else ({}, {})
    bounds = {c.symbol: (c.domain.lower, c.domain.upper) for c in declared if c.domain.kind != "angle"}
    return PhaseSpace(
        Variables(coordinates), sp.S.Zero, tuple((c.symbol, c.momentum) for c in coordinates), {},
        symbols | constants, tuple(constants.values()), TIME, bounds | ranges,
    )  # fmt: skip

"""x as a function of ∫ dx/√P, deg P = 3 or 4: x₃ − (x₃ − x₂) sn², a sn, a cn, a dn, of ω(v − v_p) and the modulus k."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots
from hjsolve.closed_form.carlson import CarlsonMap, PairsMap
from hjsolve.closed_form.even_curves import EvenMap
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities, Phase
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import monotone_inverse
from hjsolve.closed_form.real_branch_points import FAR, LegendreMap
from hjsolve.closed_form.tidy import collected, multiplied_out, square_root
from hjsolve.functions import JacobiAM, JacobiCN, JacobiDN, JacobiSN, elliptic

_FUNCTIONS = {"sn": JacobiSN, "cn": JacobiCN, "dn": JacobiDN}


def elliptic_inverse(
    change: EvenMap | LegendreMap | CarlsonMap, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities,
    unwound: Callable[[sp.Expr], sp.Expr] | None = None,
) -> sp.Expr:  # fmt: skip
    """Return the x at which ∫ dx/√P from a place has a value.

    Args:
        change: the map to Legendre's or Carlson's integrals.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.
        unwound: writes arcs of the place as functions of the coordinate.

    Raises:
        NoFormError: P has no real root to begin at.
    """
    if isinstance(change, PairsMap):
        return elliptic.inverse_between(change.points, begin, multiplied_out(amount), farther=change.farther)
    if isinstance(change, CarlsonMap):
        return _complex_pair(change, amount, begin, names)
    k = change.k
    if isinstance(change, EvenMap):
        # x = a sn, a cn or a dn (Byrd and Friedman 211 to 218), by the signs of the squares of the roots
        y = begin / _scale(change, names)
        φ_0 = {"sn": sp.asin(y), "cn": sp.acos(y), "dn": sp.asin(sp.sqrt(1 - y**2) / k)}[change.kind]
    else:
        # s = sn² u = sin² φ is the ratio of the map
        φ_0 = sp.asin(sp.sqrt(names.oriented(sp.factor(change.s(begin)))))
    # sn² , cn and dn do not change with the sign of the phase: it begins at the turning point
    even = isinstance(change, LegendreMap) or change.kind != "sn"
    start = sp.elliptic_f(monotone_inverse(φ_0 if unwound is None else unwound(φ_0)), k**2)
    return place_of_argument(
        change, Phase(names, amount, change.direction * change.rate, start, even=even).argument, names
    )


def _scale(change: EvenMap, names: NamedQuantities) -> sp.Expr:
    return names.named(
        "a", change.scale if sp.cancel(change.scale**2 - change.m) != 0 else change.k, short=SHORT, positive=True
    )


def place_of_argument(change: EvenMap | LegendreMap, u: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """X(u): a sn, a cn, a dn, or x₃ − (x₃ − x₂) sn² u between two roots.

    Args:
        change: the map to Legendre's integrals.
        u: the argument.
        names: of the quantities of the form.
    """
    if isinstance(change, EvenMap):
        return change.side * _scale(change, names) * _FUNCTIONS[change.kind](u, change.k**2)
    s = JacobiSN(u, change.k**2) ** 2
    if change.d is FAR:
        a, b = (names.named(f"x_{mark}", end, short=3 * SHORT) for mark, end in (("a", change.a), ("b", change.b)))
        return a - (names.oriented(change.a - change.b) if (a, b) == (change.a, change.b) else a - b) * s
    # b = ∞: x goes to infinity as s → 1, in a finite time (a cubic or quartic force)
    if change.b is FAR:
        return (change.a - change.d * s) / (1 - s)
    # all four points finite: a fraction of sn², of characteristic ν with s = 1/ν at x = ∞
    n = names.named("nu", names.oriented(change.pole(FAR)), short=SHORT)
    return (change.a - n * change.d * s) / (1 - n * s)


def going_round(place: sp.Expr, side: int = 1) -> sp.Expr:
    """Return a place with am u for asin(sn u) and π/2 ∓ am u for asin(cn u): arcs turn back, a rotation goes on.

    Args:
        place: of an angle that rotates.
        side: the sign of u where asin(cn u) is right.
    """
    return place.replace(
        lambda e: isinstance(e, sp.asin) and isinstance(e.args[0], JacobiSN), lambda e: JacobiAM(*e.args[0].args)
    ).replace(
        lambda e: isinstance(e, sp.asin) and isinstance(e.args[0], JacobiCN),
        lambda e: sp.pi / 2 - side * JacobiAM(*e.args[0].args),
    )


def slope_of_argument(change: EvenMap | LegendreMap, u: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """dx/du.

    Args:
        change: the map to Legendre's integrals.
        u: the argument.
        names: of the quantities of the form.
    """
    if isinstance(change, EvenMap):
        return sp.diff(place_of_argument(change, u, names), u)
    sn, cn, dn = (f(u, change.k**2) for f in (JacobiSN, JacobiCN, JacobiDN))
    if change.d is FAR:
        return 2 * (change.b - change.a) * sn * cn * dn
    n = sp.S.One if change.b is FAR else names.named("nu", names.oriented(change.pole(FAR)), short=SHORT)
    return 2 * n * (change.a - change.d) * sn * cn * dn / (1 - n * sn**2) ** 2


def modulus(names: NamedQuantities, m: sp.Expr) -> sp.Expr:
    """Return the modulus k by its name, of which the parameter is k².

    Args:
        names: of the quantities of the form.
        m: the parameter.
    """
    if m not in names.moduli:
        ratio = names.oriented(sp.factor(m))
        # k² of named roots stays a quotient of differences; of other quantities the root is taken out as far as it goes
        root = sp.sqrt(ratio) if ratio.free_symbols <= names.roots else square_root(ratio)
        names.moduli[m] = names.named("k", root, positive=True)
    return names.moduli[m]


def characteristic(names: NamedQuantities, n: sp.Expr) -> sp.Expr:
    """Return the characteristic ν of an integral of the third kind by its name.

    Args:
        names: of the quantities of the form.
        n: the characteristic.
    """
    if n not in names.moduli:
        names.moduli[n] = names.named("nu", names.oriented(sp.factor(n)))
    return names.moduli[n]


def in_moduli(expression: sp.Expr, names: NamedQuantities, *, of_roots: bool = False) -> sp.Expr:
    """Return an expression with the parameters of its elliptic integrals as k², and their characteristics by name.

    Args:
        expression: of a form.
        names: of the quantities of the forms.
        of_roots: whether only parameters that are made of named roots are named.
    """
    table = dict[sp.Expr, sp.Expr]()
    for one in sorted(
        expression.atoms(sp.elliptic_k, sp.elliptic_f, sp.elliptic_e, sp.elliptic_pi), key=sp.default_sort_key
    ):
        parameters = (one.args[-1], one.args[0]) if isinstance(one, sp.elliptic_pi) else one.args[-1:]
        for k, m in enumerate(parameters):
            if m.is_number or sp.count_ops(m) <= SHORT or (of_roots and not m.free_symbols <= names.roots):
                continue
            table[m] = characteristic(names, m) if k else modulus(names, m) ** 2
    return collected(expression.xreplace(table))


def _complex_pair(change: CarlsonMap, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """Return a ratio of linear functions of cn, or of sn²; lengths in it that are roots get names."""
    first, u = elliptic.PartialFractions(((0, sp.S.One),)), sp.Dummy("u", positive=True)
    try:
        passed = elliptic.incomplete(first, change.points, change.roots.interval, begin, change.start)
        place = elliptic.inverse(change.points, change.roots.interval, u, change.start)
    except elliptic.NoForm as error:
        raise NoFormError(str(error)) from error
    return _with_phase(place, u, names, lambda rate: (amount, change.direction * rate, rate * passed), even=True)


def root_of_square(
    change: EvenMap | LegendreMap | CarlsonMap, roots: NamedRoots, amount: sp.Expr, begin: sp.Expr,
    names: NamedQuantities,
) -> sp.Expr:  # fmt: skip
    """Return the x at which ∫ dX/√(X P(X)), X = x², from a place has a value, where the motion passes x = 0.

    Args:
        change: the map to Legendre's or Carlson's integrals.
        roots: of X P(X).
        amount: the value.
        begin: the integral from X = 0 to the place, with the sign of x there.
        names: of the quantities of the form.

    Raises:
        NoFormError: the motion does not begin at X = 0.
    """
    u = sp.Dummy("u", positive=True)
    plain = elliptic.BranchPoints(roots.leading, roots.real, roots.pairs)
    try:
        points = change.points if isinstance(change, CarlsonMap) else plain
        place = elliptic.odd_root_of_inverse(points, roots.interval, u)
    except elliptic.NoForm as error:
        raise NoFormError(str(error)) from error
    return _with_phase(place, u, names, lambda rate: (amount, rate, rate * begin), even=False)


def _with_phase(
    place: sp.Expr, u: sp.Symbol, names: NamedQuantities, phase: Callable[[sp.Expr], Sequence[sp.Expr]], *, even: bool
) -> sp.Expr:  # fmt: skip
    """Write functions of a multiple of u as those of a phase; lengths next to them that are roots get names."""
    waves = place.atoms(*_FUNCTIONS.values())
    ((argument, m),) = {wave.args for wave in waves}
    given = Phase(names, *phase(argument / u), even=even).argument, modulus(names, m) ** 2
    hidden = {wave: sp.Dummy("z") for wave in waves}
    place, z = place.xreplace(hidden), hidden.values()
    lengths = [p for p in place.atoms(sp.Pow) if p.exp == sp.S.Half and not p.has(*z) and sp.count_ops(p) > 3 * SHORT]
    place = place.xreplace({p: names.named("h", p, positive=True) for p in sorted(lengths, key=sp.count_ops)})
    return place.xreplace({name: wave.func(*given) for wave, name in hidden.items()})

"""Small oscillations: normal modes as an exact change of coordinates.

T = ½ q̇ᵀ m q̇, V = ½ qᵀ k q with constant m and k: the roots of |k − ω² m| = 0 (Greenwood (2-239)) and their amplitude
ratios make the modal matrix A with AᵀmA and AᵀkA diagonal ((2-254), (2-262)), and q = A U turns the system into
one-dimensional oscillators with ω_k² = K_kk/M_kk ((2-265), (2-266)). Repeated roots and zero roots are included.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import product
from pathlib import Path
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.coordinates.webs.orthonormal_frames import Sign, tidy_constant
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.precision import one_at_a_time
from hjsolve.separation import separate

_MOST_TRIAL_COLUMNS = 6


@dataclass(frozen=True, repr=False)
class Mode(Shown):
    """One normal mode.

    Attributes:
        name: ``mode_1``, ``mode_2``, …, in the order of rising ω².
        frequency_squared: ω² = K/M; zero for a mode that drifts, negative for one that runs away.
        mass: M_kk.
        stiffness: K_kk.
        kind: ``oscillation``, ``drift`` or ``unstable``, by the default values where a parameter decides.
    """

    name: str
    frequency_squared: sp.Expr
    mass: sp.Expr
    stiffness: sp.Expr
    kind: str


@dataclass(frozen=True, repr=False)
class NormalModes(Shown):
    """A system in its normal modes.

    Attributes:
        original: the system asked about.
        equilibrium: coordinate → its value at equilibrium q⁰.
        matrix: A of q = q⁰ + A U; columns are the amplitude ratios.
        inverse: A⁻¹ = M⁻¹ Aᵀ m, for initial conditions (Greenwood (2-272)–(2-275)).
        modes: the modes in the order of the columns.
        transformation: old coordinate → expression in the modes.
        system: the transformed system, with coordinates ``mode_1``, ``mode_2``, ….
        verdict: what ``separate`` says of it.
        exact: whether T and V were quadratic forms; else the system is an approximation for small motion.
        remark: ``linearised about q0 = …`` or empty.
    """

    original: System
    equilibrium: Mapping[str, sp.Expr]
    matrix: sp.ImmutableMatrix
    inverse: sp.ImmutableMatrix
    modes: tuple[Mode, ...]
    transformation: Mapping[str, sp.Expr]
    system: System
    verdict: Any
    exact: bool
    remark: str


@arguments.with_known_names('normal_modes(system, about={"x": 0, "y": 0})')
@one_at_a_time
def normal_modes(
    system: System | str | Path, about: Mapping[str, object] | None = None, *, budget: float = 20.0
) -> NormalModes:
    """Change to normal modes.

    Args:
        system: T and V quadratic with constant coefficients; or any system without gyroscopic terms, with ``about``;
            or the id or file of a catalog entry.
        about: an equilibrium, coordinate → value; the system is then linearised there. Coordinates left out are zero.
        budget: seconds that ``separate`` may take.

    Returns:
        A ``NormalModes`` value. Linear terms of V are removed by a shift of the origin as far as an equilibrium exists.

    Raises:
        InvalidSystemError: not quadratic and no equilibrium given; not an equilibrium; gyroscopic terms; or the
            frequencies are roots of a cubic or higher equation with symbolic coefficients.
        InvalidInputError: no system at all.

    Example:
        >>> from hjsolve import System
        >>> T = "m*l**2/2*(2*dot(a)**2 + dot(b)**2 + 2*dot(a)*dot(b))"
        >>> pendulum = System({"a": "line", "b": "line"}, T, "m*g*l/2*(2*a**2 + b**2)", {"m": 1, "l": 1, "g": 1})
        >>> [mode.frequency_squared for mode in normal_modes(pendulum).modes]
        [g*(2 - sqrt(2))/l, g*(sqrt(2) + 2)/l]
    """
    system = system_of(system, "normal_modes")
    refuse_kinks(system.kinks, "normal_modes")
    quadratic = _quadratic(system, None if about is None else arguments.table(about, "about", '{"theta": 0}'))
    sign = Sign({p.symbol: p.value for p in system.parameters if p.value is not None})
    columns = _columns(quadratic, sign)
    A = sp.ImmutableMatrix(sp.Matrix.hstack(*(sp.Matrix(v) for _, v, _ in columns)))
    modes = tuple(_mode(index, ω2, M, sign) for index, (ω2, _, M) in enumerate(columns))
    quadratic = _at_equilibrium(quadratic, A, modes)
    inverse = sp.ImmutableMatrix((sp.diag(*(1 / mode.mass for mode in modes)) * A.T * quadratic.mass).applyfunc(_tidy))
    old = sp.Matrix(quadratic.origin) + A * sp.Matrix([sp.Symbol(mode.name, real=True) for mode in modes])
    transformed = _transformed(system, quadratic, modes, A)
    names = [q.name for q in system.coordinates]
    return NormalModes(
        system,
        dict(zip(names, quadratic.origin, strict=True)),
        A,
        inverse,
        modes,
        {name: sp.expand(entry) for name, entry in zip(names, old, strict=True)},
        transformed,
        separate(transformed, budget=budget),
        quadratic.exact,
        quadratic.remark,
    )


def _mode(index: int, ω2: sp.Expr, M: sp.Expr, sign: Sign) -> Mode:
    kind = {1: "oscillation", 0: "drift", -1: "unstable"}[sign(ω2)]
    stiffness = ω2 * M if ω2.has(sp.acos) else _tidy(ω2 * M)
    return Mode(f"mode_{index + 1}", ω2, M, stiffness, kind)


@dataclass(frozen=True)
class _Quadratic:
    """T = ½ ẋᵀ m ẋ, V = const + bᵀx + ½ xᵀ k x with x = q − origin."""

    mass: sp.ImmutableMatrix
    stiffness: sp.ImmutableMatrix
    force: sp.ImmutableMatrix
    constant: sp.Expr
    origin: tuple[sp.Expr, ...]
    exact: bool
    remark: str


def _quadratic(system: System, about: Mapping[str, object] | None) -> _Quadratic:
    """Read or make the quadratic forms."""
    q = [c.symbol for c in system.coordinates]
    V = sp.expand(system.potential - kinetic_rest(system))
    M = mass_matrix(system)
    a = linear_terms(system)
    constant = not M.free_symbols & set(q) and V.is_polynomial(*q) and sp.Poly(V, *q).total_degree() <= 2
    if about is None and not constant:
        raise InvalidSystemError(
            "normal_modes: T or V is not a quadratic form with constant coefficients; give the "
            'equilibrium to linearise about, such as about={"theta": 0}'
        )
    origin = _origin(system, about or {})
    place = dict(zip(q, origin, strict=True))
    for i in range(len(q)):
        for j in range(i):
            if sp.simplify((sp.diff(a[i], q[j]) - sp.diff(a[j], q[i])).subs(place)) != 0:
                raise InvalidSystemError(
                    "normal_modes: T has gyroscopic terms (linear in the velocities and not a total "
                    "derivative); the modes are then not real one-dimensional oscillators"
                )
    force = sp.Matrix([sp.diff(V, s) for s in q]).subs(place).applyfunc(_tidy)
    k = sp.hessian(V, q).subs(place).applyfunc(_tidy)
    if not constant and any(f != 0 for f in force):
        pushed = ", ".join(f"{c.name}: {f}" for c, f in zip(system.coordinates, force, strict=True) if f != 0)
        raise InvalidSystemError(f"normal_modes: {_text(system, origin)} is not an equilibrium; dV/dq is {pushed}")
    remark = "" if constant else f"linearised about {_text(system, origin)}"
    return _Quadratic(
        sp.ImmutableMatrix(M.subs(place).applyfunc(_tidy)),
        sp.ImmutableMatrix(k),
        sp.ImmutableMatrix(force),
        _tidy(V.subs(place)),
        origin,
        constant,
        remark,
    )


def _at_equilibrium(quadratic: _Quadratic, A: sp.ImmutableMatrix, modes: Sequence[Mode]) -> _Quadratic:
    """Move the origin to where no mode with a stiffness is pushed: U_k = −f_k/K_k; a drifting mode may stay pushed."""
    forces = (A.T * quadratic.force).applyfunc(_tidy)
    shift = [sp.S.Zero if mode.stiffness == 0 else -f / mode.stiffness for f, mode in zip(forces, modes, strict=True)]
    moved = A * sp.Matrix(shift)
    energy = sp.Add(*(f * s / 2 for f, s in zip(forces, shift, strict=True)))
    origin = tuple(_tidy(o + s) for o, s in zip(quadratic.origin, moved, strict=True))
    force = (quadratic.force + quadratic.stiffness * moved).applyfunc(_tidy)
    return replace(
        quadratic, origin=origin, force=sp.ImmutableMatrix(force), constant=_tidy(quadratic.constant + energy)
    )


def _tidy(expression: sp.Expr) -> sp.Expr:
    if expression.has(sp.acos):
        return expression
    if expression.has(sp.sin, sp.cos, sp.tan):
        expression = sp.simplify(expression)
    return tidy_constant(expression)


def _text(system: System, origin: Sequence[sp.Expr]) -> str:
    return ", ".join(f"{c.name} = {o}" for c, o in zip(system.coordinates, origin, strict=True))


def _origin(system: System, about: Mapping[str, object]) -> tuple[sp.Expr, ...]:
    names = [c.name for c in system.coordinates]
    for name in about:
        if name not in names:
            raise InvalidSystemError(f"normal_modes: about: {name} is not a coordinate; they are {', '.join(names)}")
    values = (about.get(name, 0) for name in names)
    return tuple(v if isinstance(v, sp.Expr) else number(v, source="about") for v in values)


def _form(matrix: sp.MatrixBase, v: Sequence[sp.Expr]) -> sp.Expr:
    column = sp.Matrix(v)
    return _tidy(sp.expand((column.T * matrix * column)[0]))


_Column = tuple[sp.Expr, tuple[sp.Expr, ...], sp.Expr]


def _columns(quadratic: _Quadratic, sign: Sign) -> list[_Column]:
    """Return (ω², amplitude ratios, M) of every mode, m-orthogonal, ω² rising.

    ω² = s·(common factor of k)/(common factor of m), so that the equation for s has numbers only where it can.
    """
    m, k = quadratic.mass, quadratic.stiffness
    top, bottom = _content(k), _content(m)
    s = sp.Symbol("s", real=True)
    pencil = (k / top - s * m / bottom).applyfunc(sp.cancel)
    result: list[_Column] = []
    for factor, multiplicity in _secular_factors(pencil, s):
        if sp.degree(factor, s) > 2:
            result += [(_tidy_root(top / bottom * r), v, M) for r, v, M in _cubic_columns(pencil, m, factor, s)]
            continue
        for r in sp.roots(factor, s):
            ω2 = _tidy(top / bottom * r)
            space = (k - ω2 * m).applyfunc(_tidy)
            vectors = _orthogonal(_kernel(space, multiplicity), m, space)
            result += [(ω2, v, _form(m, v)) for v in vectors]
    ordered: list[_Column] = []
    for column in result:
        place = sum(1 for other in ordered if sign(other[0] - column[0]) <= 0)
        ordered.insert(place, column)
    return ordered


def _secular_factors(pencil: sp.MatrixBase, s: sp.Symbol) -> list[tuple[sp.Expr, int]]:
    """Factor |k − ω² m|."""
    numerator = sp.numer(sp.together(sp.expand(pencil.det(method="berkowitz"))))
    surds = sorted((p for p in numerator.atoms(sp.Pow) if p.is_number and not p.exp.is_Integer), key=str)
    return list(sp.factor_list(numerator, s, **({"extension": surds} if surds else {}))[1])


def _cubic_columns(pencil: sp.MatrixBase, m: sp.MatrixBase, factor: sp.Expr, s: sp.Symbol) -> list[_Column]:
    """Return (s, amplitude ratios, M) for the three roots of an irreducible cubic, by arithmetic modulo the cubic."""
    if sp.degree(factor, s) > 3 or factor.free_symbols != {s}:
        raise InvalidSystemError(
            "normal_modes: the frequencies are roots of an irreducible equation of degree "
            f"{sp.degree(factor, s)}"
            + (
                " with symbolic coefficients; give the parameters numbers"
                if factor.free_symbols != {s}
                else "; no closed form"
            )
        )

    def reduced(expression: sp.Expr) -> sp.Expr:
        return sp.rem(sp.together(sp.expand(expression)), factor, s)

    cofactors = pencil.adjugate()
    columns = ([reduced(c) for c in cofactors.col(j)] for j in range(pencil.cols))
    column = next(c for c in columns if any(e != 0 for e in c))
    lead = next(c for c in column if c != 0)
    scaled = [reduced(c * sp.invert(lead, factor, s)) for c in column]
    mass = reduced((sp.Matrix([scaled]) * m * sp.Matrix(scaled))[0])
    return [(r, tuple(c.subs(s, r) for c in scaled), mass.subs(s, r)) for r in _three_real_roots(factor, s)]


def _three_real_roots(cubic: sp.Expr, s: sp.Symbol) -> list[sp.Expr]:
    """Return the roots of a cubic with three real ones: s = −b/3a + 2√(−p/3) cos((arccos(3q/(2p)·√(−3/p)) − 2πj)/3)."""
    a, b, c, d = sp.Poly(cubic, s).all_coeffs()
    p, q = (3 * a * c - b**2) / (3 * a**2), (2 * b**3 - 9 * a * b * c + 27 * a**2 * d) / (27 * a**3)
    angle = sp.acos(sp.radsimp(3 * q / (2 * p) * sp.sqrt(-3 / p)))
    return [2 * sp.sqrt(-p / 3) * sp.cos(angle / 3 - 2 * sp.pi * j / 3) - b / (3 * a) for j in range(3)]


def _tidy_root(expression: sp.Expr) -> sp.Expr:
    return sp.expand(expression) if not expression.free_symbols else expression


def _content(matrix: sp.MatrixBase) -> sp.Expr:
    """Return the common factor of the entries, numbers left out (1 for the zero matrix)."""
    entries = [e for e in matrix if e != 0]
    if not entries:
        return sp.S.One
    common = reduce(sp.gcd, entries)
    return common if common.free_symbols else sp.S.One


def _kernel(space: sp.MatrixBase, multiplicity: int) -> list[tuple[sp.Expr, ...]]:
    """Return the amplitude ratios of a frequency: the null vectors of k − ω² m."""
    if multiplicity == 1:
        cofactors = sp.Matrix(space).adjugate()
        for j in range(space.cols):
            column = tuple(_tidy(c) for c in cofactors.col(j))
            if any(sp.simplify(c) != 0 for c in column):
                return [column]
    vectors = [tuple(v) for v in sp.Matrix(space).nullspace(simplify=True, iszerofunc=lambda e: sp.simplify(e) == 0)]
    if len(vectors) != multiplicity:
        raise InvalidSystemError("normal_modes: the mass matrix is not positive definite for the parameters given")
    return vectors


def _orthogonal(
    space: list[tuple[sp.Expr, ...]], m: sp.MatrixBase, singular: sp.MatrixBase
) -> list[tuple[sp.Expr, ...]]:
    """Return an m-orthogonal basis with simple entries, the first non-zero entry of every vector 1."""
    if len(space) == 1:
        return [_scaled(space[0])]
    chosen: list[tuple[sp.Expr, ...]] = []
    n = m.rows
    trials = product((1, 0, -1), repeat=n) if n <= _MOST_TRIAL_COLUMNS else iter(())
    simple = sorted(
        (t for t in trials if next((c for c in t if c), 0) == 1), key=lambda t: (t != (1,) * n, sum(map(abs, t)))
    )
    for trial in (tuple(map(sp.Integer, t)) for t in simple):
        inside = all(sp.simplify(e) == 0 for e in singular * sp.Matrix(trial))
        if inside and all(sp.simplify(_pair(m, trial, v)) == 0 for v in chosen):
            chosen.append(trial)
        if len(chosen) == len(space):
            return chosen
    for vector in space:
        rest = sp.Matrix(vector)
        for v in chosen:
            rest -= sp.Matrix(v) * (_pair(m, vector, v) / _pair(m, v, v))
        rest = rest.applyfunc(_tidy)
        if any(c != 0 for c in rest) and len(chosen) < len(space):
            chosen.append(_scaled(tuple(rest)))
    return chosen


def _pair(m: sp.MatrixBase, a: Sequence[sp.Expr], b: Sequence[sp.Expr]) -> sp.Expr:
    return sp.expand((sp.Matrix(a).T * m * sp.Matrix(b))[0])


def _scaled(v: tuple[sp.Expr, ...]) -> tuple[sp.Expr, ...]:
    lead = next(c for c in v if c != 0)
    return tuple(_tidy(c / lead) for c in v)


def _transformed(system: System, quadratic: _Quadratic, modes: Sequence[Mode], A: sp.MatrixBase) -> System:
    """Return the system in the modes; their names are hjsolve's own, so they are put in after the checks."""
    taken = {p.name for p in system.parameters}
    stem = next(s for s in ("u", "s", "w", "uu") if not any(name.startswith(s) for name in taken)) if taken else "u"
    names = [f"{stem}_{i + 1}" for i in range(len(modes))]
    U = [sp.Symbol(name, real=True) for name in names]
    speeds = [sp.Symbol(f"dot({name})", real=True) for name in names]
    kinetic = sp.Add(*(mode.mass * v**2 / 2 for mode, v in zip(modes, speeds, strict=True)))
    forces = (A.T * quadratic.force).applyfunc(_tidy)
    potential = quadratic.constant + sp.Add(
        *(mode.stiffness * u**2 / 2 + f * u for mode, u, f in zip(modes, U, forces, strict=True))
    )
    title = f"{system.title or 'system'} in normal modes" + (f", {quadratic.remark}" if quadratic.remark else "")
    plain = System(
        dict.fromkeys(names, "line"), kinetic, potential, {p.name: p for p in system.parameters}, title=title
    )
    return _renamed(plain, [mode.name for mode in modes])


def _renamed(system: System, names: Sequence[str]) -> System:
    """Give the coordinates other names."""
    changed, swap = [], {}
    for c, name in zip(system.coordinates, names, strict=True):
        new = replace(
            c,
            name=name,
            symbol=sp.Symbol(name, real=True),
            velocity=sp.Symbol(f"dot({name})", real=True),
            momentum=sp.Symbol(f"p_{name}", real=True),
        )
        swap.update({c.symbol: new.symbol, c.velocity: new.velocity, c.momentum: new.momentum})
        changed.append(new)
    other = object.__new__(System)
    fields = {
        **vars(system),
        "coordinates": tuple(changed),
        "kinetic": system.kinetic.xreplace(swap),
        "potential": system.potential.xreplace(swap),
    }
    for field, value in fields.items():
        object.__setattr__(other, field, value)
    return other

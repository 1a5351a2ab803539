"""Start a motion through umbilics: one that tends to them, or one that begins at an umbilic with a velocity in space.

At an umbilic p = 0 says nothing of the direction. With y = (√a δ₁, √b δ₂) places are functions of
R + i I = (y₁ + i y₂)²/2:

    ∂x/∂R = ∂₁₁x/a,    ∂x/∂I = ∂₁₂x/√(ab),

so that a velocity in space has an angle φ from ∂x/∂R, and what leaves has y₂/y₁ = tan(φ/2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import HJSolveError, InvalidInputError
from hjsolve.mechanics.system import System, mass_matrix
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import Initial, clean, read_places, with_numbers
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, checked, coordinate_start, turning_points
from hjsolve.motion.starting import motion_of
from hjsolve.motion.through_umbilics.arcs import Arcs, Corner, Corners, UmbilicArc, leaving
from hjsolve.motion.through_umbilics.branch_places import branches_only, metric_ratio
from hjsolve.motion.through_umbilics.paths import CoordinatePath, Path, path_of
from hjsolve.motion.through_umbilics.umbilic_motion import SPARE, UmbilicMotion, going_on, work_bits
from hjsolve.one_coordinate.classify import Located, locate
from hjsolve.one_coordinate.turning_points import End
from hjsolve.solution.quadratures import Solution

_MULTIPLES = 12
"""Parts of π, of which a double zero is a multiple, or else a fraction with a denominator below the next number."""
_DENOMINATORS = 2**40  # of fractions that count as meant
_ROUNDING = 1e-12
"""Of the square of a velocity."""
_NEAR = 1e-3
"""Distance from an umbilic at which a path is examined."""


def goes_on_at_umbilics(motion: Motion) -> UmbilicMotion | None:
    """Return a motion as one that goes on through umbilics; None where it is none.

    Args:
        motion: started.
    """
    kinds = set(motion.kinds.values())
    if motion.solution.system.kinks or motion.states is not None:
        return None
    if len(motion.kinds) != 2 or len(motion.separated.located) != 2 or "asymptotic" not in kinds:
        return None
    if not kinds <= {"asymptotic", "equilibrium"} or list(motion.kinds.values()).count("equilibrium") > 1:
        return None
    return _Paths(motion.solution, motion.initial, motion.digits).from_inside(motion)


class _Paths:
    """Both coordinates of a motion with given constants."""

    def __init__(self, solution: Solution, initial: Initial, digits: int):
        self.solution, self.initial, self.digits = solution, initial, max(digits, FLOAT_DIGITS)
        self.names, self.bits = list(solution.coordinates), work_bits(digits)
        self.fixed = {p.symbol: initial.values[p.symbol] for p in solution.system.parameters}
        self.known = self.fixed | {c.symbol: initial.constants[n] for n, c in solution.constants.items()}

    def from_inside(self, motion: Motion) -> UmbilicMotion | None:
        """Return the motion of one that starts between umbilics."""
        located = {name: motion.separated.located[name] for name in self.names}
        resting = [k for k, place in enumerate(located.values()) if place.coordinate_motion.kind == "equilibrium"]
        for name in [self.names[k] for k in resting]:
            e = self.initial.values[self.solution.system.coordinate(name).symbol]
            # p² has a double zero there: its path is that of the region above it
            beside = self._beside(name, e, 1)
            if beside is None:
                return None
            located[name] = beside
        made = self._arcs_of([self._coordinate_motion(name, place) for name, place in located.items()])
        if made is None:
            return None
        paths, corners = made
        x, d = zip(*(self._start(name, path) for name, path in zip(self.names, paths, strict=True)), strict=True)
        if resting:
            (k,) = resting
            arc = UmbilicArc((d[0], d[1]), None, -d[1 - k] * paths[1 - k].time(x[1 - k]), k)
        else:
            # x = tanh z: levels are linear in z where x rounds to 1
            z = [v.context.atanh(v) for v in x]
            level = sum(side * path.level(a, b) for side, path, a, b in zip(d, paths, z, x, strict=True))
            arc = UmbilicArc(
                (d[0], d[1]), level, -sum(w * path.time(b) for w, path, b in zip(d, paths, x, strict=True))
            )
        return self._motion(motion, arc, paths, corners)

    def _start(self, name: str, path: Path) -> tuple[Mpf, int]:
        c = self.solution.system.coordinate(name)
        place = to_bits(self.initial.values[c.symbol])(self.bits)
        p = to_bits(self.initial.values[c.momentum])(self.bits)
        x, d = path.coordinate_motion.position(place, (p > 0) - (p < 0))
        # p = 0 at the end of a path: the coordinate rests there, and d names that end
        return x, d or (1 if x > 0 else -1)

    def _coordinate_motion(self, name: str, place: Located) -> CoordinatePath | None:
        """Return the path of a coordinate between double zeros; None where it does not come back to one."""
        ends = {-1: place.lower, 1: place.upper}
        radicand = coordinate_start(self.solution, self.initial, name).radicand
        zeros = {side: self._zero(end) for side, end in ends.items() if end.kind == "asymptote"}
        if None in zeros.values() or not zeros:
            return None
        # exact double zeros give as many bits as wanted; a zero that was found has half as many as p²
        values = {side: to_bits(e)(self.bits) for side, e in zeros.items() if e is not None}
        if len(values) == 2:
            return CoordinatePath(radicand, values[-1], values[1], None)
        ((side, e),) = values.items()
        turning = ends[-side]
        if turning.kind != "turning" or turning.place is None:
            return None
        return CoordinatePath(radicand, e, e, turning.place(self.bits))

    def _zero(self, end: End) -> sp.Expr | None:
        """Return a double zero as an exact number: a part of π or a fraction; None where it is neither."""
        if end.place is None:
            return None
        x = end.place(512)
        return _exact(x)

    def _arcs_of(self, coordinate_motions: list[CoordinatePath | None]) -> tuple[tuple[Path, Path], Corners] | None:
        """Paths and corners; None where no end of an arc is reached in a finite time."""
        one, two = coordinate_motions
        if one is None or two is None:
            return None
        weight = self._weight(one, two)
        if weight is None:
            return None
        digits = self.digits + SPARE
        paths = path_of(one, weight, digits, self.bits), path_of(two, weight, digits, self.bits)
        return paths, partial(self._corner, paths)

    def _corner(self, paths: tuple[Path, Path], sides: tuple[int, int]) -> Corner:
        """Return the end of an arc at which both coordinates are at the named ends of their paths."""
        coordinate_motions = [path.coordinate_motion for path in paths]
        ends = [_exact(c.upper if side > 0 else c.lower) for c, side in zip(coordinate_motions, sides, strict=True)]
        place = tuple(e for e in ends if e is not None)
        one, two = (p.residues[side > 0] for p, side in zip(paths, sides, strict=True))
        # d₁L₁ = −c ln ε₁ and d₂L₂ = c ln ε₂ with one c: else ε₂/ε₁ has no limit, and no direction goes on
        same = abs(one + two) <= one.context.mpf(10) ** -self.digits * abs(one)
        ratio = None
        if same and len(place) == len(ends):
            # M₁₁ = h a and M₂₂ = h b must vanish together there, even about the place: else y₁ + i y₂ has no square
            ratio = metric_ratio(self.solution.system, tuple(self.fixed.items()), place)
        if ratio is None:
            return Corner(False, 0 * one)
        squares = tuple(sp.sympify(self.solution.momentum_squared[name]).subs(self.known) for name in self.names)
        passable = branches_only(self.solution.system, tuple(self.fixed.items()), place, squares)
        sizes = [
            abs(c.upper - c.lower) / 2 if c.turning is None else 2 * abs(c.turning - c.lower)
            for c in coordinate_motions
        ]
        c = one.context
        # y₂/y₁ = √(M₂₂/M₁₁) δ₂/δ₁, and δᵢ = sizeᵢ εᵢ
        return Corner(passable, c.log(sizes[1] / sizes[0]) - c.log(to_bits(ratio)(self.bits)) / 2)

    def _weight(self, one: CoordinatePath, two: CoordinatePath) -> Mpf | None:
        """W with k₁ + w k₂ = 0 at every double zero; None where there is no such number."""
        found = []
        for coordinate_motion in (one, two):
            for e in (coordinate_motion.lower, coordinate_motion.upper):
                kernels = coordinate_motion.radicand.weights(e, self.bits)
                if len(kernels) != 2 or not kernels[1]:
                    return None
                # the kernels grow as 1/δ at a double zero: with k₁ + w k₂ = 0 there the time of an arc is finite
                found.append(-kernels[0] / kernels[1])
        tiny = found[0].context.mpf(10) ** -(self.digits + SPARE)
        return found[0] if all(abs(w - found[0]) <= tiny * (1 + abs(found[0])) for w in found) else None

    def _motion(
        self, motion: Motion, arc: UmbilicArc, paths: tuple[Path, Path], corners: Corners
    ) -> UmbilicMotion | None:  # fmt: skip
        kinds = [self.solution.system.coordinate(name).domain.kind for name in self.names]
        free = [k for k, kind in enumerate(kinds) if kind in {"angle", "line"}]
        return going_on(motion, Arcs(arc, paths, corners), free[0]) if free else None

    # ------------------------------------------------------------------------------------------------ at an umbilic
    def from_umbilic(
        self, place: tuple[sp.Expr, sp.Expr], direction: tuple[Mpf, Mpf], t0: sp.Expr, parts: frozenset[str]
    ) -> UmbilicMotion | None:
        """Return the motion that leaves an umbilic, y₁ and y₂ in the ratio given."""
        sides = [1 if y >= 0 else -1 for y in direction]
        beside = [self._beside(n, e, s) for n, e, s in zip(self.names, place, sides, strict=True)]
        located = {n: found for n, found in zip(self.names, beside, strict=True) if found is not None}
        if len(located) < len(beside):
            return None
        made = self._arcs_of([self._coordinate_motion(n, found) for n, found in located.items()])
        if made is None:
            return None
        paths, corners = made
        begins, resting = [], None
        for k, (path, e, y) in enumerate(zip(paths, place, direction, strict=True)):
            coordinate_motion, here = path.coordinate_motion, to_bits(e)(self.bits)
            # a path with a turning point has its one double zero at both ends, the lower one by convention
            below = coordinate_motion.turning is not None or abs(coordinate_motion.lower - here) < abs(
                coordinate_motion.upper - here
            )
            begins.append(-1 if below else 1)
            if not y:
                resting = k
        directions = [-here for here in begins]
        if resting is not None:
            # of a coordinate that rests ``directions`` holds the end at which it does (see UmbilicArc)
            directions[resting] = begins[resting]
        corner = corners((begins[0], begins[1]))
        c = direction[0].context
        slope = None if resting is not None else c.log(abs(direction[1] / direction[0]))
        arc = leaving(paths, (directions[0], directions[1]), corner, slope, resting, c.zero)
        base = SeparatedMotion(
            self.solution, self.initial, t0, self.digits, parts, located, None, turning_points(located, self.digits), {}
        )
        return self._motion(motion_of(base), arc, paths, corners)

    def _beside(self, name: str, e: sp.Expr, side: int) -> Located | None:
        """Return the region of a coordinate beside a double zero."""
        c = self.solution.system.coordinate(name)
        values = {**self.initial.values, c.symbol: e + side * sp.Rational(_NEAR).limit_denominator(1000)}
        values[c.momentum] = sp.Integer(side)
        begin = coordinate_start(self.solution, replace(self.initial, values=values), name)
        plain = replace(begin, forward=side, radicand=coordinate_start(self.solution, self.initial, name).radicand)
        try:
            return locate(checked(replace(plain, parts=frozenset[str]())), FLOAT_DIGITS)
        except HJSolveError:
            return None


def _exact(x: Mpf) -> sp.Expr | None:
    """Return a part of π or a fraction that a number is to its digits; None where it is neither."""
    c = x.context
    # a double zero is known to half the bits of p²
    tiny = c.ldexp(1 + abs(x), -min(c.prec, 512) // 2)
    fraction = c.nint(_MULTIPLES * x / c.pi)
    if abs(x - fraction * c.pi / _MULTIPLES) <= tiny:
        return sp.pi * sp.Rational(int(fraction), _MULTIPLES)
    sign, mantissa, exponent, _ = x._mpf_
    whole = int(mantissa) * (-1 if sign else 1)
    exact = sp.Rational(whole) * sp.Rational(2) ** exponent
    near = sp.Rational(exact).limit_denominator(_DENOMINATORS)
    return near if abs(x - c.mpf(int(near.p)) / int(near.q)) <= tiny else None


def start_at_umbilic(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], velocity: Mapping[str, sp.Expr], t0: sp.Expr, digits: int,
    parts: frozenset[str], *, place: Mapping[str, sp.Expr], energy: sp.Expr, exact: bool,
) -> UmbilicMotion:  # fmt: skip
    """Start at an umbilic with a velocity in space.

    Args:
        solution: of a system of two coordinates.
        values: parameters and coordinates, exact.
        velocity: axis of the place → component.
        place: axis → x(q), of which T = m/2 ẋ·ẋ.
        energy: E, an exact number.
        exact: whether no number given is a float.

    Raises:
        InvalidInputError: the place is not an umbilic that a motion passes, or the velocity is zero.
    """
    system = solution.system
    refused = InvalidInputError("q: T vanishes there, and the place is not an umbilic through which a motion continues")
    q = [c.symbol for c in system.coordinates]
    fixed = {p.symbol: values[p.symbol] for p in system.parameters}
    if len(q) != 2 or list(solution.coordinates) != [c.name for c in system.coordinates]:
        raise refused
    here = values[q[0]], values[q[1]]
    ratio = metric_ratio(system, tuple(fixed.items()), here)
    if ratio is None:
        raise refused
    if not any(velocity.values()):
        raise InvalidInputError("velocity: is zero; a body at rest at an umbilic or focus is not started")
    initial = replace(_at_rest(solution, values, energy), exact=exact)
    bits = work_bits(digits)
    c = Multi(bits).context
    # at an umbilic ∂x/∂q = 0 and places are of second order: x ≈ ½ Σ ∂ᵢⱼx δᵢδⱼ
    second = [
        [to_bits(sp.diff(x, *pair).subs(fixed).subs(dict(zip(q, here, strict=True))))(bits) for x in place.values()]
        for pair in ((q[0], q[0]), (q[0], q[1]))
    ]
    v = [to_bits(velocity[axis])(bits) for axis in place]
    root = c.sqrt(to_bits(ratio)(bits))
    across = second[0], [root * y for y in second[1]]
    real, imaginary = (c.fsum(a * b for a, b in zip(row, v, strict=True)) for row in across)
    refuse_normal(c.fsum(y**2 for y in v), (real**2 + imaginary**2) / c.fsum(y**2 for y in second[0]))
    # half the angle in space: places are functions of the square of y₁ + i y₂
    angle = c.atan2(imaginary, real) / 2
    # a rounded sine of a multiple of π is not a slow coordinate, but one that rests
    one, two = (c.zero if abs(y) < c.ldexp(1, -bits // 2) else y for y in (c.cos(angle), c.sin(angle)))
    direction = one, two
    motion = _Paths(solution, initial, digits).from_umbilic(here, direction, t0, parts)
    if motion is None:
        raise refused
    return motion


def refuse_normal(whole: float | Mpf, along: float | Mpf) -> None:
    """Refuse a velocity that leaves the surface.

    Args:
        whole: its square.
        along: the square of what lies in the tangent plane.

    Raises:
        InvalidInputError: they differ by more than rounding.
    """
    if abs(float(whole - along)) > _ROUNDING * float(whole):
        raise InvalidInputError("velocity: is not tangent to the surface on which the coordinates are")


def _at_rest(solution: Solution, values: Mapping[sp.Symbol, sp.Expr], energy: sp.Expr) -> Initial:
    """Return Initial data with p = 0, and the constants with which p² = 0 at the place in both coordinates."""
    system = solution.system
    names = {name: c.symbol for name, c in solution.constants.items()}
    (other,) = [name for name in names if name != "E"]
    at = {**values, names["E"]: energy}
    squares = [sp.sympify(f).subs(at) for f in solution.momentum_squared.values()]
    found = [sp.solve(f, names[other]) for f in squares]
    if any(len(one) != 1 for one in found):
        raise InvalidInputError("q: p**2 does not vanish there for any separation constant: it is not an umbilic")
    constant = clean(found[0][0])
    momenta = {c.momentum: sp.S.Zero for c in system.coordinates}
    return Initial({**values, **momenta}, {n: energy if n == "E" else constant for n in names}, True)


def particle_mass(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return m of T = m/2 ẋ·ẋ, x(q) the place of the system.

    Args:
        system: that says where its coordinates are.
        values: parameter → exact number.

    Raises:
        InvalidInputError: T is not that of one particle there.
    """
    q, M = [c.symbol for c in system.coordinates], mass_matrix(system)
    J = sp.Matrix(list(system.place.values())).jacobian(q)
    fixed = {p.symbol: values[p.symbol] for p in system.parameters}
    G, metric = (J.T * J).subs(fixed), M.subs(fixed)
    # somewhere in general position: that T = m/2 ẋ·ẋ is an identity, so two places refute it
    at = {s: sp.Rational(3 + 2 * k, 7 + 4 * k) for k, s in enumerate(q)}
    m = sp.nsimplify(sp.N((metric[0, 0] / G[0, 0]).subs(at), 60), rational=True, tolerance=sp.Float(10) ** -40)
    for shift in (0, sp.Rational(1, 5)):
        there = {s: x + shift for s, x in at.items()}
        rows = [(metric[i, j] - m * G[i, j]).subs(there) for i in range(len(q)) for j in range(len(q))]
        if any(abs(sp.N(x, 40)) > sp.Float(10) ** -30 for x in rows):
            raise InvalidInputError(
                "velocity: along x, y, z T must be that of one particle at its place; give that of the coordinates"
            )
    return m


def momenta_of(
    system: System, values: Mapping[sp.Symbol, sp.Expr], velocity: Mapping[str, sp.Expr]
) -> dict[str, sp.Expr]:  # fmt: skip
    """Return p = m (∂x/∂q)ᵀ v of a velocity in space.

    Args:
        system: that says where its coordinates are.
        values: parameters and coordinates, exact.
        velocity: axis of the place → component.

    Raises:
        InvalidInputError: T is not that of one particle there, or the velocity leaves the surface.
    """
    mass, q = particle_mass(system, values), [c.symbol for c in system.coordinates]
    J = sp.Matrix([[with_numbers(sp.diff(x, s), values) for s in q] for x in system.place.values()])
    v = sp.Matrix([velocity[axis] for axis in system.place])
    lifted, rows = J.T * v, J.evalf(30)
    # the part of v in the tangent plane, J (JᵀJ)⁻¹ Jᵀ v: what is normal to it has no momentum
    flat = rows * (rows.T * rows).LUsolve(rows.T * v.evalf(30))
    refuse_normal(float((v.T * v)[0]), float((flat.T * flat)[0]))
    return {c.name: mass * lifted[k] for k, c in enumerate(system.coordinates)}


def hint_at_umbilic(solution: Solution, q: Mapping[str, object], parameters: Mapping[str, object] | None) -> str:
    """Return how to start at an umbilic; nothing at another place.

    Args:
        q, parameters: as given.
    """
    system = solution.system
    try:
        values = read_places(system, q, parameters)
    except HJSolveError:
        return ""
    place = tuple(values[c.symbol] for c in system.coordinates)
    if (
        len(place) != 2
        or metric_ratio(system, tuple((p.symbol, values[p.symbol]) for p in system.parameters), place) is None
    ):
        return ""
    axes = ", ".join(f'"{axis}": …' for axis in system.place or ("x", "y", "z"))
    declared = "" if system.place else " to a System(…, place={…})"
    return f". It is an umbilic: give the velocity in space, velocity={{{axes}}}{declared}"

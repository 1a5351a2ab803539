"""One degree of freedom with a given H(q, p) that is not T + V: solved for p.

    H(q, p) = a(q) p + b(q) = E:        p = (E − b)/a,     W = ∫ p dq,     t − β = ∂W/∂E = ∫ dq/a      (Greenwood P5-1)

is linear in p: no square root, one branch, and no turning point; q moves in one direction for ever, at the rate a(q).

    H(q, p) = a(q) p² + b(q) p + c(q):  L = (q̇ − b)²/(4a) − c

is a natural system with a term linear in the velocity, and becomes a ``System``. Any other H(q, p), such as p⁴ + q² or
√(1 + p²) + q², has branches p(q; E), solved for numerically, and t − β = ∂W/∂E = ∫ dq/(∂H/∂p) along them (Greenwood
(5-71) with ∂p/∂E = 1/(∂H/∂p)); its motions are followed where they come back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.extended.from_momenta import read_with_momenta, system_from_momenta
from hjsolve.extended.one_freedom import (
    Beginning,
    LinearInMomentum,
    NonlinearInMomentum,
    OfOneCoordinate,
    StartedByMomenta,
)
from hjsolve.formulas.read import parse
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter, clock_of
from hjsolve.mechanics.periodicity import is_periodic
from hjsolve.mechanics.system import System
from hjsolve.precision import one_at_a_time

if TYPE_CHECKING:
    from hjsolve.arithmetic.number_types import Mpf
    from hjsolve.extended.level_motion import LevelMotion
    from hjsolve.extended.linear_hamiltonian_motion import LinearMotion
    from hjsolve.extended.scaled_hamiltonians import ScaledFrame, ScaledMotion
    from hjsolve.extended.sums_of_hamiltonians import SumMotion


@dataclass(frozen=True, repr=False)
class LinearHamiltonian(LinearInMomentum, StartedByMomenta["LinearMotion"]):
    """H = a(q) p + b(q), solved; its fields and formulas are those of ``LinearInMomentum``."""

    _reason = "dq/dt = a(q) says nothing about p here"

    def _started(self, begin: Beginning) -> LinearMotion:
        from hjsolve.extended.linear_hamiltonian_motion import start_linear_motion

        return start_linear_motion(self, begin)

    def at(
        self, t: object, *, q: object, p: object, t0: object = 0, digits: int = 15
    ) -> tuple[float | Mpf, float | Mpf]:
        """Return (q, p) at one time; ``motion`` gives their errors as well.

        Args:
            t: the time.
            q: position at t0.
            p: momentum at t0.
            t0: initial time.
            digits: relative digits wanted.

        Raises:
            OutsideMotionError: q reaches infinity or an end of its domain before.
        """
        name = self.coordinate.name
        return self.motion(q={name: q}, p={name: p}, t0=t0, digits=digits).reach(t)


@dataclass(frozen=True, repr=False)
class GeneralHamiltonian(NonlinearInMomentum, StartedByMomenta["LevelMotion"]):
    """H(q, p) that is of neither first nor second degree in p; its fields are those of ``NonlinearInMomentum``."""

    def _started(self, begin: Beginning) -> LevelMotion:
        from hjsolve.extended.level_motion import start_on_level

        return start_on_level(self, begin)


@dataclass(frozen=True, repr=False)
class HamiltonianInTime(OfOneCoordinate, Shown, StartedByMomenta["ScaledMotion"]):
    """K(q, p, t) of one coordinate that does not hold the time in a scaled frame that moves evenly.

    Attributes:
        coordinate: q.
        hamiltonian: K.
        frame: X = (q + v t) e^{a t}, Y = p e^{−a t} and K′(X, Y).
        problem: what ``from_hamiltonian`` makes of K′.
        parameters: with their default values.
        title, id: for display.
    """

    coordinate: Coordinate
    hamiltonian: sp.Expr
    frame: ScaledFrame
    problem: LinearHamiltonian | GeneralHamiltonian
    parameters: tuple[Parameter, ...] = ()
    title: str = ""
    id: str = ""

    def _started(self, begin: Beginning) -> ScaledMotion:
        from hjsolve.extended.scaled_hamiltonians import start_scaled

        return start_scaled(self.frame, self.problem, self.parameters, begin)


@dataclass(frozen=True, repr=False)
class SumOfHamiltonians(Shown, StartedByMomenta["SumMotion"]):
    """H = Σ h(q, p) of parts that share no coordinate.

    Attributes:
        coordinates: of all parts.
        hamiltonian: H.
        parts: what ``from_hamiltonian`` makes of each h.
        parameters: with their default values.
        title, id: for display.
    """

    coordinates: tuple[Coordinate, ...]
    hamiltonian: sp.Expr
    parts: tuple[System | LinearHamiltonian | GeneralHamiltonian | HamiltonianInTime, ...]
    parameters: tuple[Parameter, ...] = ()
    title: str = ""
    id: str = ""

    def _started(self, begin: Beginning) -> SumMotion:
        from hjsolve.extended.sums_of_hamiltonians import start_sum

        in_time = any(
            part.time is not None if isinstance(part, System) else isinstance(part, HamiltonianInTime)
            for part in self.parts
        )
        return start_sum(self.parts, begin, in_time=in_time)


@arguments.with_known_names('from_hamiltonian("p**2/2 + q**4", {"q": "line"})')
@one_at_a_time
def from_hamiltonian(
    hamiltonian: str, coordinates: Mapping[str, str], parameters: Mapping[str, object] | None = None, *,
    title: str = "", id: str = "",  # noqa: A002
) -> System | LinearHamiltonian | GeneralHamiltonian | HamiltonianInTime | SumOfHamiltonians:  # fmt: skip
    """Take a system from H(q, p), written with ``p``, or with ``p_`` and the name of the coordinate.

    Args:
        hamiltonian: H. Of one coordinate any function of it and of its momentum; of several a polynomial of second
            degree in the momenta, or V + sqrt(m**2*c**4 + c**2*(…)) with parameters m and c of any names, or a sum of
            such Hamiltonians that share no coordinate. With the time t of second degree in the momenta, or of one
            coordinate any that does not hold it in X = (q + v t) e^{a t}, Y = p e^{−a t}.
        coordinates: name → domain.
        parameters: name → value, as for ``System``.
        title: for display.
        id: permanent name, for display.

    Returns:
        A ``System`` where H is quadratic in p, by the Legendre transformation back to T and V (Greenwood (4-14)); a
        ``LinearHamiltonian`` where it is linear, else a ``GeneralHamiltonian``; with the time in H a
        ``HamiltonianInTime``. Of several coordinates a
        ``SumOfHamiltonians`` where H is of higher degree and a sum.

    Raises:
        InvalidSystemError: no p in H, an H that is not periodic in its angle, or of several coordinates an H of
            another form.

    Example:
        >>> problem = from_hamiltonian("q + p", {"q": "line"})
        >>> problem.principal_function
        E*q - E*t - q**2/2
    """
    table = arguments.table(coordinates, "coordinates", '{"q": "line"}')
    if not table:
        raise InvalidSystemError('H(q, p): no coordinate; write coordinates={"q": "line"}')
    if len(table) > 1:
        try:
            return system_from_momenta(hamiltonian, coordinates, parameters, title, id)
        except InvalidSystemError:
            found = _sum(hamiltonian, coordinates, parameters, title, id)
            if found is None:
                raise
            return found
    ((name, domain),) = coordinates.items()
    if taken := {"p", f"p_{name}"} & {name, *(parameters or {})}:
        raise InvalidSystemError(f"H(q, p): {min(taken)} is the momentum; rename the coordinate or parameter")
    shape = System(coordinates, f"dot({name})**2/2", "0", parameters)
    q = shape.coordinate(name)
    clock = {c.name: c.symbol for c in clock_of((hamiltonian,), shape.symbols)}
    H = parse(hamiltonian, {**shape.symbols, **clock, "p": q.momentum, f"p_{name}": q.momentum}, source="hamiltonian")
    if not H.has(q.momentum):
        raise InvalidSystemError("H(q, p): it does not contain p")
    if clock and not (H.is_polynomial(q.momentum) and sp.degree(H, q.momentum) == 2):
        return _in_time(H, shape, clock["t"], title, id)
    if not H.is_polynomial(q.momentum) or sp.degree(H, q.momentum) not in (1, 2):
        numbers = {s.symbol: s.value for s in shape.parameters if s.value is not None}
        if domain == "angle" and not (is_periodic(H, q.symbol) or is_periodic(H.xreplace(numbers), q.symbol)):
            raise InvalidSystemError(f"H(q, p): is not shown to have period 2*pi in {name}, which is an angle")
        return GeneralHamiltonian(q, H, tuple(shape.parameters), title, id)
    coefficients = sp.Poly(H, q.momentum).all_coeffs()
    if len(coefficients) == 2:
        return LinearHamiltonian(q, H, coefficients[0], coefficients[1], tuple(shape.parameters), title, id)
    a, b, c = coefficients
    kinetic = sp.expand((q.velocity - b) ** 2 / (4 * a))
    return System({name: domain}, kinetic, c, parameters, title=title, id=id)


def _in_time(H: sp.Expr, shape: System, clock: sp.Symbol, title: str, id_: str) -> HamiltonianInTime:
    """Return K(q, p, t) in the frame in which it does not hold the time."""
    from hjsolve.extended.scaled_hamiltonians import scaled_frame

    (q,) = shape.coordinates
    frame = scaled_frame(H, q, clock)
    if frame is None:
        raise InvalidSystemError(
            "H(q, p, t): with the time t H of second degree in p is taken, and H that does not hold it in "
            "X = (q + v*t)*exp(a*t), Y = p*exp(-a*t); no such frame was found"
        )
    parameters = {p.name: p for p in shape.parameters if p.symbol in frame.hamiltonian.free_symbols}
    inner = from_hamiltonian(str(frame.hamiltonian), {q.name: q.domain.written(q.name)}, parameters)
    if not isinstance(inner, (LinearHamiltonian, GeneralHamiltonian)):
        raise InvalidSystemError("H(q, p, t): write it as a polynomial in p")
    return HamiltonianInTime(q, H, frame, inner, tuple(shape.parameters), title, id_)


def _sum(
    hamiltonian: str, coordinates: Mapping[str, str], parameters: Mapping[str, object] | None, title: str, id_: str
) -> SumOfHamiltonians | None:
    """Return H as a sum of Hamiltonians that share no coordinate; None where it is not one."""
    from hjsolve.extended.sums_of_hamiltonians import independent_parts, used_parameters

    shape, H, _ = read_with_momenta(hamiltonian, coordinates, parameters)
    groups = independent_parts(H, shape.coordinates)
    if len(groups) < 2:
        return None
    parts = []
    for own, h in groups:
        needed = used_parameters(shape.parameters, own, h)
        part = from_hamiltonian(str(h), {c.name: coordinates[c.name] for c in own}, needed)
        if isinstance(part, SumOfHamiltonians):
            return None
        parts.append(part)
    return SumOfHamiltonians(shape.coordinates, H, tuple(parts), shape.parameters, title, id_)

"""Why a quantity has no form: a proof, as data that can be worked out again, or what was tried.

Each kind holds what its proof rests on; ``holds`` decides it anew, and the text is made from the data. A kind without a
proof says what was not found, and no more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import sympy as sp

from hjsolve.display.shown import Shown

_DIGITS = 40
"""Of the ratio of two logarithms at rational constants."""
_REAL = sp.Rational(1, 10**30)
"""Above this part of 1 an imaginary part, known to so many digits, is none of rounding."""


class Term(Protocol):
    """One integral of a law; ``elementary.BasicIntegral`` is one."""

    @property
    def kind(self) -> str:
        """Arcsine, …, root, line."""

    @property
    def leading(self) -> sp.Expr:
        """It is a logarithm, or an arc function, over √ of this."""

    @property
    def ratio(self) -> sp.Expr:
        """Of two logarithms in one, the square of the ratio of their factors; 1 of one alone."""


class Law(Protocol):
    """An integral a(x) √P + Σ c I(x); ``elementary.Antiderivative`` is one."""

    @property
    def x(self) -> sp.Symbol:
        """The variable."""

    @property
    def polynomial(self) -> sp.Expr:
        """P."""

    @property
    def algebraic(self) -> sp.Expr:
        """The rational factor of √P."""

    @property
    def terms(self) -> Sequence[tuple[sp.Expr, Term]]:
        """The c and the I."""


@dataclass(frozen=True, repr=False)
class WhyNot(Shown):
    """Why a quantity has no form.

    Attributes:
        proved: whether it is proved that there is none; False where none was found.
    """

    proved: ClassVar[bool] = False

    def holds(self) -> bool:
        """Decide anew what the proof rests on; False where there is no proof."""
        return False


@dataclass(frozen=True, repr=False)
class NotFound(WhyNot):
    """No form was found, or what was found was not verified.

    Attributes:
        text: what was tried.
    """

    text: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, repr=False)
class TranscendentalEquation(WhyNot):
    """The time law t = a(x) √P + Σ cₖ Iₖ(x) holds two independent functions of x: Kepler's equation, and its like.

    The inverse of an elementary function F is elementary only if F is a chain of functions of one variable, each
    algebraic, exp or log (Ritt, Trans. Amer. Math. Soc. 27 (1925) 68); of an algebraic function and a logarithm, or of
    two logarithms whose factors have no rational ratio, F is none.

    Attributes:
        coordinate: q.
        law: t as a function of x.
    """

    proved: ClassVar[bool] = True
    coordinate: str
    law: Law

    def holds(self) -> bool:
        """Return whether the law has an algebraic part and a logarithm, or two logarithms with an irrational ratio."""
        law, at = self.law, dict[sp.Symbol, sp.Expr]()
        held = (law.polynomial, law.algebraic, *(e for c, t in law.terms for e in (c, t.leading, t.ratio)))
        symbols = set().union(*(e.free_symbols for e in held))
        for k, s in enumerate(sorted(symbols - {law.x}, key=str)):
            # at numbers that nobody chose: what holds there is not a special case, and is decided exactly
            at[s] = sp.Rational(13 + 8 * k, 11 + k)
        logarithms = [(c, t) for c, t in law.terms if t.kind not in ("root", "line")]
        residues = [sp.cancel(c.xreplace(at) ** 2 / t.leading.xreplace(at)) for c, t in logarithms]
        # c/√(leading) is the factor of the logarithm: its square is rational where the root is not
        residues = [r for r in residues if r != 0]
        # an algebraic function and a logarithm are independent: Ritt's chain would have to be both
        if residues and (law.algebraic.xreplace(at) != 0 or len(logarithms) < len(law.terms)):
            return True
        if any(abs(sp.im(sp.N(t.ratio.xreplace(at), _DIGITS))) > _REAL for _, t in logarithms):
            return True  # of poles at complex places
        # n log u + m log v = log uⁿ vᵐ for whole n, m: one function. Of an irrational ratio there is none
        ratios = [sp.simplify(r / residues[0]) for r in residues[1:]]
        return any(r.is_Rational and not sp.sqrt(r).is_Rational for r in ratios)

    def __str__(self) -> str:
        q, kinds = self.coordinate, [term.kind for _, term in self.law.terms]
        what = {"arcsine": "Kepler's equation", "area cosine right": "Kepler's equation of the hyperbola"}
        if len(kinds) == 1 and self.law.algebraic != 0 and kinds[0] in what:
            return f"t({q}) is {what[kinds[0]]}: {q}(t) has no closed form"
        return f"t({q}) holds two independent functions of {q}: {q}(t) has no closed form"


@dataclass(frozen=True, repr=False)
class NotOfTheFirstKind(WhyNot):
    """The time is an elliptic integral, R dx/√P with R not constant: x(t) is not an elliptic function of t.

    For it to be one dt must have neither zeros nor poles on the curve.

    Attributes:
        coordinate: q.
        x: the variable.
        rational: R.
    """

    proved: ClassVar[bool] = True
    coordinate: str
    x: sp.Symbol
    rational: sp.Expr

    def holds(self) -> bool:
        """Return whether R varies."""
        return sp.cancel(sp.diff(self.rational, self.x)) != 0

    def __str__(self) -> str:
        q = self.coordinate
        return f"t({q}) contains integrals of the second or third kind: {q}(t) is not an elliptic function of t"


@dataclass(frozen=True, repr=False)
class IndependentIntegrals(WhyNot):
    """The time law and an orbit equation hold integrals over one coordinate that are not multiples of each other.

    Attributes:
        coordinate: over which they are.
        q: its symbol.
        ratio: of the integrands.
    """

    proved: ClassVar[bool] = True
    coordinate: str
    q: sp.Symbol
    ratio: sp.Expr

    def holds(self) -> bool:
        """Return whether the ratio of the integrands varies."""
        return sp.cancel(sp.together(sp.diff(self.ratio, self.q))) != 0

    def __str__(self) -> str:
        return (
            f"the time law and the orbit equations contain different integrals over {self.coordinate}: "
            "they must be solved together"
        )


@dataclass(frozen=True, repr=False)
class HighGenus(WhyNot):
    """The momentum's curve y² = P(x) has genus two or more once its reflections are divided out.

    An integral of the first kind on it is neither elementary (Liouville) nor elliptic, unless the curve covers an
    elliptic one in another manner than by an involution, which is not excluded.

    Attributes:
        place: x as a function of q.
        polynomial: P at rational constants.
        reduced: what is left of it after the reflections.
        steps: how many there were.
        involution: whether a Möbius involution of what is left is known; None where it was not looked for.
    """

    place: sp.Expr
    polynomial: sp.Poly
    reduced: sp.Poly
    steps: int
    involution: bool | None

    def holds(self) -> bool:
        """Return whether both polynomials are free of squares, and what is left is of degree five or more."""
        free = all(sp.gcd(P, P.diff()).degree() == 0 for P in (self.polynomial, self.reduced))
        return free and self.genus >= 2 and not self.involution

    @property
    def proved(self) -> bool:  # type: ignore[override]
        """Whether no reflection and no involution makes it elliptic."""
        return self.genus >= 2 and not self.involution

    @property
    def genus(self) -> int:
        """Of what is left."""
        # y² = P, squarefree, of degree 2g + 1 or 2g + 2
        return (int(self.reduced.degree()) - 1) // 2

    def __str__(self) -> str:
        degree = int(self.polynomial.degree())
        text = f"y² = P({self.place}) of degree {degree} has genus {(degree - 1) // 2}"
        if self.steps:
            text += f", by its reflections {self.genus}"
        if self.genus < 2:
            return f"{text}: it is elliptic in another variable, which is not done here"
        if self.involution:
            return f"{text}, and reduces by a Möbius involution, which is not done here"
        if self.involution is not None:
            text += ", and no Möbius involution reduces it"
        return f"{text}: no closed form in these functions"


@dataclass(frozen=True, repr=False)
class OfCoordinate(WhyNot):
    """The reason is that of one coordinate's integral.

    Attributes:
        coordinate: its name.
        reason: of its integral.
    """

    coordinate: str
    reason: WhyNot

    @property
    def proved(self) -> bool:  # type: ignore[override]
        """As of the reason."""
        return self.reason.proved

    def holds(self) -> bool:
        """As of the reason."""
        return self.reason.holds()

    def __str__(self) -> str:
        return f"{self.coordinate}: {self.reason}"


@dataclass(frozen=True, repr=False)
class Contains(WhyNot):
    """A quantity is a function of another that has no form.

    Attributes:
        quantity: as a function of the time, φ(t).
        other: r(t).
        reason: of the other; None where it is not known.
    """

    quantity: str
    other: str
    reason: WhyNot | None

    @property
    def proved(self) -> bool:  # type: ignore[override]
        """As of the reason."""
        return self.reason is not None and self.reason.proved

    def holds(self) -> bool:
        """As of the reason."""
        return self.reason is not None and self.reason.holds()

    def __str__(self) -> str:
        return f"{self.quantity} contains {self.other}" + ("" if self.reason is None else f", and {self.reason}")

r"""How the action of a coordinate at rest changes, and how a motion next to it moves.

At a double zero of F = p², F = −x²G(x) about the place of rest, the action is the limit of a vanishing libration. Its
integral (1/2π) ∮ √F dq round both turning points does not change when its path is drawn away from them, and there it
can be differentiated; what is left is the residue at x = 0,

    J_b = [x⁰] ½ F_b G^(−1/2),      J_jb = [x⁰] ½ F_jb G^(−1/2) + [x²] ¼ F_j F_b G^(−3/2).

A motion next to it does x″ = ½ F_qq x in the time τ with dq/dτ = P: it oscillates with √(−F_qq/2), or runs away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.motion.derivatives.bounded import Bounded
from hjsolve.motion.derivatives.formulas import AtPlace, SquareDerivatives
from hjsolve.one_coordinate.coordinate_motion import AtRest


@dataclass(frozen=True, eq=False)
class RestVariations:
    """A coordinate at rest, with the derivatives of what a motion next to it does.

    Attributes:
        coordinate_motion: the coordinate.
        formulas: of its p².
        at: F and its derivatives at the place of rest.
        context: of the numbers.
    """

    coordinate_motion: AtRest
    formulas: SquareDerivatives
    at: AtPlace
    context: Context

    rests = True

    @property
    def stiffness(self) -> Mpf:
        """−F_qq/2: positive where a motion next to it oscillates."""
        return -self.at.bend / 2

    @property
    def regular(self) -> bool:
        """Whether F has a double zero there, not a triple one or higher."""
        return bool(abs(self.at.bend) > self.context.ldexp(1, -self.context.prec // 2))

    def place_by(self) -> list[Mpf]:
        """Return how the place of rest moves: q_b = −F_qb/F_qq."""
        return [-by / self.at.bend for by in self.at.slope_by]

    def top(self, j: int, b: int) -> Mpf:
        """Return the second derivative of the maximum of F over q, F_jb − F_qj F_qb/F_qq.

        Args:
            j: position of a constant.
            b: position of a variable.
        """
        return self.at.mixed[j][b] - self.at.slope_by[j] * self.at.slope_by[b] / self.at.bend

    def flow(self, χ: Mpf) -> tuple[Mpf, list[list[Mpf]]]:
        """Return τ and the matrix that takes (x, y) of a motion next to it over the phase χ.

        Args:
            χ: phase gone through, √(−F_qq/2) τ where it oscillates, τ itself elsewhere.
        """
        c = self.context
        # dx/dτ = y = p and dy/dτ = F_q/2 = −κ x, κ = −F_qq/2: next to the place of rest, to first order
        rate = abs(self.stiffness) ** 0.5
        if self.coordinate_motion.stable:
            cosine, sine = c.cos(χ), c.sin(χ)
            return χ / rate, [[cosine, sine / rate], [-rate * sine, cosine]]
        if self.stiffness > 0:
            cosine, sine = c.cos(rate * χ), c.sin(rate * χ)
            return χ, [[cosine, sine / rate], [-rate * sine, cosine]]
        cosine, sine = c.cosh(rate * χ), c.sinh(rate * χ)
        return χ, [[cosine, sine / rate], [rate * sine, cosine]]

    def means(self) -> Bounded:
        """Return J_b, shape (variables,)."""
        rate = self.stiffness**0.5
        # a small libration has J = F_top/(2√κ), the area of an ellipse over 2π (Greenwood (5-83))
        return Bounded.exact(np.array([by / rate / 2 for by in self.at.by], dtype=object))

    def second_means(self) -> Bounded:
        """Return J_jb, shape (constants, variables)."""
        own, *by, mixed = self.formulas.expansions(self.coordinate_motion.rest, self.context.prec)
        A, n, count = -own[2] / 2, len(self.formulas.variables.constants), self.formulas.variables.count
        u, v = own[3] / 6 / (own[2] / 2), own[4] / 24 / (own[2] / 2)
        root = A**0.5
        # F = −A x² (1 + ux + vx²) about the rest: J_jb = (1/2π) ∮ F_jb/(2F^½) − F_j F_b/(4F^(3/2)) dq by residues
        first, second = -3 * u / 2, 15 * u * u / 8 - 3 * v / 2  # of (1 + ux + vx²)^(−3/2)
        value = np.empty((n, count), dtype=object)
        for j in range(n):
            f = by[j][0], by[j][1], by[j][2] / 2
            for b in range(count):
                g = by[b][0], by[b][1], by[b][2] / 2
                product = f[0] * g[0], f[0] * g[1] + f[1] * g[0], f[0] * g[2] + f[1] * g[1] + f[2] * g[0]
                bent = (product[2] + product[1] * first + product[0] * second) / (A * root)
                value[j, b] = mixed[j * count + b] / root / 2 + bent / 4
        return Bounded.exact(value)


def rest_variations(coordinate_motion: AtRest, formulas: SquareDerivatives, digits: int) -> RestVariations:
    """Differentiate what a motion next to a place of rest does.

    Args:
        coordinate_motion: the coordinate at rest.
        formulas: of its p².
        digits: wanted.
    """
    bits = bits_for(digits, 96)
    context = multiprecision(bits)
    rest = context.convert(coordinate_motion.rest)
    return RestVariations(coordinate_motion, formulas, formulas.bound(bits).at(rest), context)

"""Gauss' rule for mpmath's ``quad``, its nodes by FLINT: mpmath needs 15 s for those of 768 at 60 digits, FLINT 0.1 s."""

from __future__ import annotations

from functools import cache
from typing import Any

from mpmath.calculus.quadrature import GaussLegendre


class _Gauss(GaussLegendre):
    """mpmath's rule; only where its nodes come from differs."""

    def calc_nodes(self, degree: int, prec: int, verbose: bool = False) -> list[tuple[Any, Any]]:
        """Zeros of P_n and their weights, n = 3·2^(degree − 1), from balls narrower than the precision."""
        try:
            import flint
        except ImportError:
            return super().calc_nodes(degree, prec, verbose)
        count, nodes = 3 * 2 ** (degree - 1), []
        with flint.ctx.workprec(prec + 40), self.ctx.workprec(prec + 20):
            for k in range(count):
                pair = flint.arb.legendre_p_root(count, k, weight=True)
                assert all(ball.rel_accuracy_bits() > prec + 16 for ball in pair if ball != 0)
                (x, power), (w, other) = (map(int, ball.mid().man_exp()) for ball in pair)
                nodes.append((self.ctx.ldexp(x, power), self.ctx.ldexp(w, other)))
        return nodes


@cache
def gauss(context: Any) -> _Gauss:
    """The rule of a context of mpmath, to be given as ``method``."""
    return _Gauss(context)

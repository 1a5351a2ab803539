"""The panels of an open motion, made one after the other as far as they are asked for (``chebyshev_panels``).

On each panel values at Chebyshev points give the series Σ cₖ Tₖ of an integrand, and its integral term by term, Σ (cₖ₋₁
− cₖ₊₁)/2k Tₖ times half the length (Mason & Handscomb, Chebyshev Polynomials, 2003, (2.43)). How long a panel may be
and how many points it takes is proved beforehand (``panel_length``).
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Protocol

import numpy as np

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth, waves
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.chebyshev_panels import EndMap, Panels, chebyshev_points, integrated_row
from hjsolve.one_coordinate.panel_length import Surroundings, longest, nodes_for
from hjsolve.one_coordinate.time_along_a_path import stopwatch

_MAX_PANELS = 1600  # each may be four times as long as the last
_GROWTH, _LONGEST, _FIRST = 4.0, 8.0, 2.0
"""The longest panel tried: a multiple of the last one, at most this towards an asymptote; the first one."""
_COSTLIEST = 4
"""Nodes of one panel, over those for integrands that are no larger in the ellipse than on the panel."""
_RETRIES = 8
"""How often a panel is shortened whose integrands are smaller than their bounds made them look."""


class Integrated(Protocol):
    """Functions of y in many digits, with what is known of them about a place; see ``open_branch.Branch``."""

    def integrands(self, y: Mpf, extra: int = 0) -> list[Mpf]:
        """Return the values of all functions at y (``mpf``), with so many bits more than usual."""
        ...

    def cancelled(self, y: Mpf, extra: int) -> int:
        """Return the bits more than usual that the functions need at y, at least ``extra``."""
        ...

    def around(self, y: Mpf, rest: float) -> Surroundings:
        """Return where the functions are analytic about y; ``rest`` is left from there to the greatest y."""
        ...


class Growing:
    """The integrals along a branch, panel by panel, as far as they were asked for; what is there is never done again.

    The panels do not depend on how far is asked for: a shorter reach has the first ones of a longer.
    """

    def __init__(self, end_map: EndMap, coordinate_motion: Integrated, *, digits: int, bits: int):
        """Start at y = 0.

        Args:
            end_map: the branch.
        """
        self.end_map, self.coordinate_motion, self.digits, self.bits, self.extra = (
            end_map,
            coordinate_motion,
            digits,
            bits,
            0,
        )
        self.context = multiprecision(bits)
        self.last = end_map.last(self.context)
        # the first panel is at most ``_FIRST`` long: the map makes y a number of order one there
        self.step = self.context.mpf(_FIRST) / _GROWTH
        # a shorter panel, in proportion to y, has both edges in one double: the way to infinity is given up there
        self.finest = self.context.mpf(2) ** -(50 if digits <= 15 else bits // 2)
        self.edges, self.values, self.sums, self.totals = [self.context.mpf(0)], [], [], []  # type: ignore[var-annotated]
        self.nodes: list[int] = []
        self.over = self.blown = False
        self.failed: NotConvergedError | None = None
        self.lock = Lock()

    def until(self, enough: Callable[[Mpf, list[Mpf]], bool]) -> Panels:
        """Return the panels up to the first that is enough, or to the last there is.

        Args:
            enough: (y, integrals so far) ↦ True when the branch is long enough.

        Raises:
            TooSlowError: not in the time that it may take.
            NotConvergedError: too many panels; the integrand could not be shown to be analytic along the branch.
        """
        count, check = 0, stopwatch(self.digits)
        with self.lock:
            while count < len(self.values) or not self.over:
                if count == len(self.values):
                    check(lambda: f"the integrals on the way to {self.end_map.end}; {self._reached(self.edges[-1])}")
                    self._grow()
                count += 1
                if enough(self.edges[count], self.totals[count - 1]):
                    break
        return self._first(count)

    def known(self) -> Panels:
        """Return the panels there are, after no further ones converged: the path is known up to their end.

        Raises:
            NotConvergedError: there are none.
        """
        if self.failed is not None and not self.values:
            raise self.failed
        return self._first(len(self.values))

    def _first(self, count: int) -> Panels:
        y, kind = self.edges[count], float if self.digits <= 15 else object
        ends = self.over and count == len(self.values)
        return Panels(
            np.array(self.edges[: count + 1], dtype=kind),
            np.array(_filled(self.values[:count]), dtype=kind).transpose(1, 0, 2),
            np.array(_filled(self.sums[:count]), dtype=kind).transpose(1, 0, 2),
            self.nodes[count - 1],
            ends or (self.last is not None and bool(y >= self.last * (1 - 2.0**-40))),
        )

    def _grow(self) -> None:
        """Add one panel."""
        if self.failed is None:
            try:
                rows, nodes = self._resolved()
            except NotConvergedError as error:
                self.failed = error
        if self.failed is not None:
            raise self.failed
        context, y = self.context, self.edges[-1] + self.step
        # each panel begins with the sum of all before it, in many digits
        before = self.totals[-1] if self.totals else [context.mpf(0)] * len(rows)
        integrated = [integrated_row(row, self.step / 2, total) for row, total in zip(rows, before, strict=True)]
        after = [context.fsum(row) for row in integrated]
        self.values.append(rows)
        self.sums.append(integrated)
        self.totals.append(after)
        self.edges.append(y)
        self.nodes.append(nodes)
        fraction = max(context.mpf(1), y / self.step)  # a short panel adds little, far from where the integrals settle
        self.blown = self.end_map.end == "infinity" and _settled(before, after, fraction, self.digits)
        # the end; or, where it is not analytic there, near enough
        self.over = self.blown or (
            self.last is not None and self.last - y <= self.last * context.mpf(10) ** -self.digits
        )

    def _resolved(self) -> tuple[list[list[Mpf]], int]:
        """Chebyshev coefficients over the next panel, proved to be enough, and the nodes used so far."""
        y, nodes = self.edges[-1], self.nodes[-1] if self.nodes else 0
        if len(self.values) > _MAX_PANELS:
            raise NotConvergedError(
                f"more than {_MAX_PANELS} panels on the way to {self.end_map.end}; {self._reached(y)}"
            )
        rest = 0.0 if self.last is None else float(self.last - y)
        # no longer than four times the last: where the integrands change their scale it shows in steps
        around, most = self.coordinate_motion.around(y, rest), _GROWTH * float(self.step)
        if self.last is not None:
            # no sliver before the end: it would cost as many nodes as a panel
            most = min(most, rest) if most < rest / 2 else rest
        elif self.end_map.end != "infinity":
            most = min(most, _LONGEST)
        for _ in range(_RETRIES):
            # the length for which a strip of analyticity is proved, and the nodes for that
            reach = longest(around, most, self.digits, float(y))
            if reach is None or (self.end_map.end == "infinity" and reach.length <= y * self.finest):
                break
            # exactly the end where the panel reaches it, though the length was a double
            self.step = self.last - y if reach.length == rest else self._to_a_double(y, reach.length)
            count, most = reach.nodes, reach.length / 2
            ends = [y + self.step] if self.last is None or y + self.step < self.last else []
            # p² next to an end of the branch cancels more the nearer it comes: bits are added as they are lost
            extra = max([self.extra, *(self.coordinate_motion.cancelled(end, self.extra) for end in ends)])
            while count <= _COSTLIEST * nodes_for(0.0, self.digits):
                points = chebyshev_points(smooth(count), self.bits)
                rows = _expand(self.coordinate_motion, y, self.step, points, self.bits, extra)
                nodes += len(points)
                # the proof is relative to the size of the integrands, which is known now: it may ask for more nodes
                count = reach.nodes_for([max(abs(c) for c in row) for row in rows], self.digits)
                if count <= len(points):
                    self.extra = extra
                    return rows, nodes
        raise NotConvergedError(
            f"the integrand could not be shown to be smooth near y = {float(y):.6g} on its way to {self.end_map.end}; "
            + self._reached(y)
        )

    def _to_a_double(self, y: Mpf, length: float) -> Mpf:
        """Return a step of at most this length whose end is a double where doubles are wanted.

        Edges that are rounded later shift each panel by itself; where the integrals are steep that is another time.
        """
        end = float(y + length)
        # rounded down: the panel must not be longer than what was proved
        if end > y + length:
            end = float(np.nextafter(end, 0.0))
        return self.context.mpf(end) - y if self.digits <= 15 and end > y else self.context.mpf(length)

    def _reached(self, y: Mpf) -> str:
        q, _ = self.end_map.position(y, Multi(self.bits))
        return f"the integrals are known up to q = {float(q):.9g}"


def _filled(rows: list[list[list[Mpf]]]) -> list[list[list[Mpf]]]:
    """Series of panels, all of the same length."""
    longest_ = max(len(series) for panel in rows for series in panel)
    return [[[*series, *[0 * series[0]] * (longest_ - len(series))] for series in panel] for panel in rows]


def _settled(before: list[Mpf], after: list[Mpf], fraction: Mpf, digits: int) -> bool:
    """Return True when the integrals (the momentum's apart) no longer grow: infinity is reached in a finite time.

    A panel that is the share-th part of the way would have added so much more, had it been as long as the way.
    """
    tiny = fraction.context.mpf(10) ** -(digits + 3)
    return all(fraction * abs(b - a) <= tiny * abs(b) for a, b in zip(before[:-1], after[:-1], strict=True))


def _expand(
    coordinate_motion: Integrated, y: Mpf, step: Mpf, points: list[Mpf], bits: int, extra: int
) -> list[list[Mpf]]:
    """Chebyshev coefficients on [y, y + step] from values at Chebyshev points."""
    context, n = multiprecision(bits), len(points)
    samples = [coordinate_motion.integrands(y + step * (1 + x) / 2, extra) for x in points]
    rows = []
    for column in zip(*samples, strict=True):
        values = [context.convert(v) for v in column]
        # values at Chebyshev points are an even function of the angle: a cosine transform gives the coefficients
        waves_ = waves(values, even=True, bits=bits)[0] if any(values) else [context.mpf(0)] * (n - 1)
        rows.append([context.fsum(values) / n, *waves_])
    return rows

"""What the page computes from its tables, computed here in the same way: the series at a setting, the state at times.

Jacobi's equations Σᵢ Kᵢⱼ(χᵢ) = δⱼ₁ t + const for the separated constants, multiplied by the inverse of the mean
growths: χₖ + Σᵢ Dₖᵢ(χᵢ) = θₖ, the angle variables, which grow by Ωₖ t (``time_law.torus``). The
script of the page has the same lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.live.neighbours import WAVES, LiveCoordinate

Columns = Mapping[tuple[int, str], Array]
"""(position of a coordinate, group) → numbers at one setting, shape (n,)."""


class PageMotion:
    """The motion at one setting of the sliders, from its columns."""

    def __init__(self, coordinates: Sequence[LiveCoordinate], ignorable: Sequence[str], columns: Columns):
        n = len(coordinates)
        self.coordinates, self.ignorable, self.columns = tuple(coordinates), tuple(ignorable), columns
        means = np.array([[self._wave(i, str(j))[0][0] for i in range(n)] for j in range(n)])
        self.growth = np.linalg.inv(means)
        self.rates = self.growth[:, 0]
        self._oscillations = [[self._oscillation(k, i) for i in range(n)] for k in range(n)]
        begin = np.array([c.phase for c in coordinates])
        self.begin = begin + self._bent(begin[:, None])[:, 0]

    def _wave(self, i: int, group: str) -> tuple[Array, Array]:
        """Cosines 0 … and sines 0 … of a column; zero where there is none."""
        column = self.columns.get((i, group), np.zeros(1))
        sines = np.concatenate([[0.0], column[WAVES:]]) if len(column) > WAVES else np.zeros(1)
        return column[:WAVES], sines

    def _oscillation(self, k: int, i: int) -> tuple[Array, Array]:
        """Cosines and sines of dDₖᵢ/dχ, without the mean."""
        c, s = np.zeros(WAVES), np.zeros(WAVES)
        for j in range(len(self.coordinates)):
            for total, part in zip((c, s), self._wave(i, str(j)), strict=True):
                total[: len(part)] += self.growth[k, j] * part
        c[0] = 0
        return c, s

    def _bent(self, χ: Array) -> Array:
        """Σᵢ Dₖᵢ(χᵢ), shape (n, m)."""
        return np.array([sum(_integral(*self._oscillations[k][i], x) for i, x in enumerate(χ)) for k in range(len(χ))])

    def _slopes(self, χ: Array) -> Array:
        n = len(χ)
        slopes = [[(k == i) + _value(*self._oscillations[k][i], χ[i]) for i in range(n)] for k in range(n)]
        return np.array(slopes).transpose(2, 0, 1)

    def phases(self, t: Array) -> Array:
        """Return χ, not reduced to one turn: Newton's method with steps halved until they help.

        Args:
            t: times, shape (m,).
        """
        θ = self.begin[:, None] + np.outer(self.rates, t)
        turns = 2 * np.pi * np.round(θ / (2 * np.pi))
        goal = θ - turns
        χ = goal.copy()
        miss = χ + self._bent(χ) - goal
        for _ in range(60):
            step = np.linalg.solve(self._slopes(χ), miss.T[..., None])[..., 0].T
            fraction = np.ones(len(t))
            size = np.abs(miss).max(axis=0)
            for _ in range(12):
                new = χ - fraction * step
                left = new + self._bent(new) - goal
                worse = ~(np.abs(left).max(axis=0) <= (1 - fraction / 4) * size) & (size > 1e-13)
                if not worse.any():
                    break
                fraction = np.where(worse, fraction / 2, fraction)
            χ, miss = new, left
            if np.abs(fraction * step).max() < 1e-14:
                break
        return χ + turns

    def state(self, t: Array) -> dict[str, Array]:
        """Return q, ``p_`` of the separated coordinates and the gains of the ignorable ones since the start.

        Args:
            t: times from the start, shape (m,).
        """
        χ, found = self.phases(t), {}
        for i, own in enumerate(self.coordinates):
            cosines, sines = self._wave(i, "root")
            root = _value(cosines, sines, χ[i])
            if own.direction:
                found[own.name], found[f"p_{own.name}"] = own.direction * χ[i], own.direction * root
            else:
                a, b = (float(self.columns[i, end][0]) for end in ("a", "b"))
                found[own.name] = (a + b) / 2 - (b - a) / 2 * np.cos(χ[i])
                found[f"p_{own.name}"] = (b - a) / 2 * np.sin(χ[i]) * root
        n = len(self.coordinates)
        for k, name in enumerate(self.ignorable):
            total = np.zeros(len(t))
            for i, own in enumerate(self.coordinates):
                c, s = self._wave(i, str(n + k))
                total -= c[0] * (χ[i] - own.phase)
                total -= _integral(c, s, χ[i]) - _integral(c, s, np.array([own.phase]))
            found[name] = total
        return found


def _integral(cosines: Array, sines: Array, χ: Array) -> Array:
    """∫ from 0 to χ without the mean."""
    k = np.arange(1, len(cosines))
    m = np.arange(1, len(sines))
    return np.asarray(
        np.sin(np.outer(χ, k)) @ (cosines[1:] / k) + (1 - np.cos(np.outer(χ, m))) @ (sines[1:] / m), float
    )


def _value(cosines: Array, sines: Array, χ: Array) -> Array:
    waves = np.cos(np.outer(χ, np.arange(len(cosines)))) @ cosines
    return np.asarray(waves + np.sin(np.outer(χ, np.arange(len(sines)))) @ sines, float)

"""How nodes are drawn together: u = K/π (χ + γ₁ sin χ + ½ γ₂ sin 2χ); see ``nodes``."""

from __future__ import annotations

CLUSTERINGS = (
    (0.0, 0.0), (-0.7, 0.0), (-0.495, 0.175), (0.0, 0.7), (0.495, 0.175), (0.7, 0.0), (0.0, 0.0), (0.0, 0.7),
    (0.0, -0.7),
)  # fmt: skip
"""γ₁, γ₂: none, then crowded at χ = 0, π/4, π/2, 3π/4, π; for even motions none, at π/2, and at both ends."""

BARRIER_TOP = len(CLUSTERINGS)
"""Stands for nodes that crowd about a crest of the potential; see ``nodes_about_barrier_tops``."""

EVEN = 6
"""From here on the motion is even about its middle: half of the half period serves, series go in 2χ."""

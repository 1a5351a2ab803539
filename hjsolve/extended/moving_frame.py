"""A moving frame, and the motions that are started in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hjsolve import arguments
from hjsolve.extended.change_of_frame import ChangeOfFrame

if TYPE_CHECKING:
    from hjsolve.extended.moving_frame_motion import FramedMotion


@dataclass(frozen=True, repr=False)
class Frame(ChangeOfFrame):
    """A system with explicit time and the autonomous one it becomes; its fields are those of ``ChangeOfFrame``."""

    @arguments.by_name('motion(q={"q": "0.3"}, velocity={"q": "0.4"}, t0="0.5")')
    def motion(
        self, *, q: Mapping[str, object], velocity: Mapping[str, object] | None = None,
        p: Mapping[str, object] | None = None, parameters: Mapping[str, object] | None = None,
        t0: object = 0, digits: int = 15,
    ) -> FramedMotion:  # fmt: skip
        """Start a motion from initial data of the original system.

        Args:
            q: position of every original coordinate.
            velocity: of every original coordinate, or
            p: its canonical momentum.
            parameters: values that differ from the defaults.
            t0: the initial time; it matters, since the original system contains the time.
        """
        from hjsolve.extended.moving_frame_motion import start_framed_motion

        return start_framed_motion(self, q=q, velocity=velocity, p=p, parameters=parameters or {}, t0=t0, digits=digits)

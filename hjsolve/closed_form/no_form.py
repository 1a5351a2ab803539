"""The exception inside this room: an integral that has no form here, and why."""

from __future__ import annotations


class NoFormError(Exception):
    """These functions do not hold the integral; the message says why. Never leaves the room."""

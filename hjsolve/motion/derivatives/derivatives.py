"""What ``Motion.derivatives`` does: derivatives of results and states, brought to what is varied."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from hjsolve import arguments
from hjsolve.arithmetic.floats import EPS, bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Mpf, Numbers, Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER
from hjsolve.errors import InvalidInputError, required
from hjsolve.motion.derivative_values import DEPENDENT, NOT_ALONE, OK, REMARKS, SQUARE_ROOT, MotionDerivatives
from hjsolve.motion.derivatives.along_branch import OpenVariations
from hjsolve.motion.derivatives.along_cycle import CycleVariations
from hjsolve.motion.derivatives.angle_slopes import angles_by, differentiable_angles
from hjsolve.motion.derivatives.at_rest import RestVariations
from hjsolve.motion.derivatives.bounded import Bounded, stacked, zeros
from hjsolve.motion.derivatives.canonical import ConstantsToState
from hjsolve.motion.derivatives.in_users_coordinates import UsersCoordinates, users_coordinates
from hjsolve.motion.derivatives.integrals import MeanMatrix, action_by, has_means, mean_matrix
from hjsolve.motion.derivatives.preparation import prepared
from hjsolve.motion.derivatives.transition import exactly, matrices, start_in_users_coordinates, transition_matrix
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.shapes import Shape
from hjsolve.motion.times import read_times

OF = ("actions", "frequencies", "periods", "turning_points", "constants", "angles", "state")
"""What may be differentiated."""
BY = ("initial", "constants", "parameters", "actions")
"""What it may be differentiated by."""


@dataclass(frozen=True, eq=False)
class Inputs:
    """One group of what is varied, by (B, x, a, y) and the parameters, and by constants and parameters.

    Attributes:
        names: of its variables.
        by_frame: how (B, x, a, y, λ) change with each of them, shape (columns, variables); None where they do not.
        by: how constants and parameters do, shape (constants and parameters, variables).
    """

    names: tuple[str, ...]
    by_frame: Bounded | None
    by: Bounded


_Columns = list[tuple[Inputs, Bounded | None]]
"""By what, and the derivatives of all q and p by it, shape (times, 2n, inputs); None where there are none."""


@dataclass
class _Collected:
    digits: int
    value: dict[str, dict[str, dict[str, object]]] = field(default_factory=dict)
    error: dict[str, dict[str, dict[str, object]]] = field(default_factory=dict)
    status: dict[str, dict[str, str]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def put(
        self,
        quantity: str,
        name: str,
        group: Inputs,
        rows: Sequence[Bounded | None],
        shape: tuple[int, ...] | None = (),
    ) -> None:
        """Keep the derivatives of one number (of a pair of them) by one group.

        Args:
            quantity, name: of the number.
            rows: the derivatives by the group, last axis; one, or a pair with None where there is no number.
            shape: of the times; the first axis of a row is that of the times where there is one.
        """
        values = self.value.setdefault(quantity, {}).setdefault(name, {})
        errors = self.error.setdefault(quantity, {}).setdefault(name, {})
        self.status.setdefault(quantity, {}).setdefault(name, OK)
        for k, variable in enumerate(group.names):
            found = [(None, None) if row is None else self.rounded(row[..., k], shape) for row in rows]
            pair: tuple[object, ...] = found[0] if len(rows) == 1 else tuple(zip(*found, strict=True))
            values[variable], errors[variable] = pair

    def refuse(self, quantity: str, name: str, group: Inputs, status: str, pair: bool = False) -> None:
        """Keep nan for the derivatives of a number, and why.

        Args:
            quantity, name: of the number.
            status: the word for why.
            pair: whether it is a pair of numbers.
        """
        nan = float("nan")
        for table, filler in ((self.value, nan), (self.error, nan)):
            row = table.setdefault(quantity, {}).setdefault(name, {})
            row.update(dict.fromkeys(group.names, (filler, filler) if pair else filler))
        self.status.setdefault(quantity, {})[name] = status
        remark = REMARKS[status].format(name=name)
        if remark not in self.remarks:
            self.remarks.append(remark)

    def rounded(self, found: Bounded, shape: tuple[int, ...] | None = ()) -> tuple[AtTimes, AtTimes]:
        """Return a number, or an array of the shape of the times, rounded to the digits asked, with its error."""
        value, error = (
            np.asarray(found.value, dtype=object),
            SECOND_ORDER * np.asarray(found.error, dtype=float),
        )
        if self.digits <= FLOAT_DIGITS:
            plain = value.astype(float)
            bound = error + EPS * np.abs(plain) / 2
        else:
            context = multiprecision(bits_for(self.digits, 16))
            plain = np.frompyfunc(context.convert, 1, 1)(value)
            bound = error + float(multiprecision(64).mpf(10) ** -self.digits) * np.asarray(
                np.abs(value), dtype=object
            ).astype(float)
        if shape:
            return np.reshape(plain, shape), np.reshape(bound, shape)
        one = np.ravel(np.asarray(plain, dtype=object))[0]
        return one, float(np.ravel(bound)[0])


def derivatives_of(motion: Motion, of: Iterable[str], by: Iterable[str], t: object) -> MotionDerivatives:
    """Differentiate a motion; see ``Motion.derivatives``."""
    wanted, varied = _words(of, "of", OF), _words(by, "by", BY)
    if "actions" in varied and wanted & {"state", "angles"}:
        raise InvalidInputError(
            'derivatives: by={"actions"} is for actions, frequencies, periods, turning points and constants; the state '
            'and the angles depend on angles too, write by={"initial"} or {"constants"}'
        )
    users = users_coordinates(motion, parameters="parameters" in varied)
    map_ = prepared(motion.as_solved, "parameters" in varied)
    found = _Collected(motion.digits)
    if map_ is None:
        _even_state(motion, wanted, varied, t, found)
        return MotionDerivatives(found.value, found.error, found.status)
    means = mean_matrix(map_)
    for group in _groups(map_, users, means, varied):
        _numbers(motion, map_, means, group, wanted, found)
        if "angles" in wanted:
            _angles(motion, map_, means, group, t, found)
    if "state" in wanted:
        _state(motion, map_, users, varied, t, found)
    return MotionDerivatives(found.value, found.error, found.status, tuple(found.remarks))


def _even_state(motion: Motion, wanted: frozenset[str], varied: frozenset[str], t: object, found: _Collected) -> None:
    """Return the state of a motion all of whose coordinates are ignorable: q grows evenly.

    Raises:
        InvalidInputError: anything else is asked, or by something else.
    """
    if wanted != {"state"} or not varied <= {"initial", "parameters"}:
        raise InvalidInputError(
            "derivatives: every coordinate is ignorable, so that q grows evenly and J is p; of such a motion there is "
            'of={"state"} by={"initial", "parameters"}; frequencies are derivatives of '
            "solution.separation.shell.potential"
        )
    shape, floats, exact = _times(motion, t)
    main, by, _ = matrices(motion, floats, exact, parameters="parameters" in varied)
    system = motion.solution.system
    names = [q.name for q in system.coordinates]
    groups = _of_the_start(names, tuple(p.name for p in system.parameters), varied, main, by)
    _put_states(found, names, groups, shape)


def _of_the_start(
    names: Sequence[str], parameters: tuple[str, ...], varied: frozenset[str], main: Bounded, by: Bounded
) -> _Columns:
    own = tuple([f"q.{name}" for name in names] + [f"p.{name}" for name in names])
    empty = Bounded.exact(np.zeros((0, 0), dtype=object))
    groups = {"initial": (own, main), "parameters": (parameters, by)}
    return [(Inputs(what, None, empty), rows) for key, (what, rows) in groups.items() if key in varied]


def _put_states(found: _Collected, names: Sequence[str], columns: _Columns, shape: Shape) -> None:
    n = len(names)
    for group, rows in columns:
        for k in range(2 * n):
            if rows is None:
                found.refuse("qp"[k >= n], names[k % n], group, DEPENDENT)
            else:
                found.put("qp"[k >= n], names[k % n], group, [rows[:, k]], shape)


def _words(given: Iterable[str], what: str, known: Sequence[str]) -> frozenset[str]:
    names = arguments.words(given, what, '{"frequencies"}')
    for name in sorted(names - set(known)):
        raise InvalidInputError(f'{what}: "{name}" is not known; known are {", ".join(known)}')
    return names


def _groups(
    map_: ConstantsToState, users: UsersCoordinates | None, means: MeanMatrix | None, varied: frozenset[str]
) -> list[Inputs]:
    """Return what is varied, in terms of the constants of the motion."""
    solution, n = map_.source.solution, map_.freedoms
    system, c, m = solution.system, map_.context, len(map_.variables.parameters)
    (inverse, by_parameters), Z = start_in_users_coordinates(map_, users), map_.variations(2 * n + m)
    names = users.names if users is not None else [q.name for q in system.coordinates]
    groups = []

    def padded(top: Bounded, bottom: Numbers) -> Bounded:
        zero = np.zeros(bottom.shape)
        return Bounded(np.concatenate([top.value, bottom]), np.concatenate([top.error, zero]))

    if "initial" in varied:
        frame = padded(inverse, np.full((m, 2 * n), c.mpf(0), dtype=object))
        own = tuple([f"q.{name}" for name in names] + [f"p.{name}" for name in names])
        groups.append(Inputs(own, frame, Z @ frame))
    if "parameters" in varied:
        identity = np.array([[c.mpf(int(i == j)) for j in range(m)] for i in range(m)], dtype=object).reshape(m, m)
        frame = padded(by_parameters, identity)
        groups.append(Inputs(map_.variables.parameters, frame, Z @ frame))
    if "constants" in varied:
        groups.append(_constants(map_))
    if "actions" in varied and means is not None:
        known = means.inverse
        directions = [p.coordinate_motion.direction if isinstance(p, CycleVariations) else 1 for p in map_.parts]
        # the actions of rotations carry the sign of p, K has them without it
        columns = [known[:, k] if d > 0 else -known[:, k] for k, d in enumerate(directions)]
        columns += [known[:, k] for k in range(len(map_.parts), len(known.value))]
        others = [q.name for q in system.coordinates if q.name not in solution.coordinates]
        by = padded(stacked(columns, 1), np.full((m, len(known.value)), c.mpf(0), dtype=object))
        groups.append(Inputs(tuple(f"J.{name}" for name in [*solution.coordinates, *others]), None, by))
    return groups


def _constants(map_: ConstantsToState) -> Inputs:
    """Return the constants themselves, at constant β."""
    c, n, m = map_.context, map_.freedoms, len(map_.variables.parameters)
    constants = map_.variables.constants
    by = zeros((map_.variables.count, len(constants)), c)
    for j in range(len(constants)):
        by.value[j, j] = c.mpf(1)
    if map_.resting:
        return Inputs(constants, None, by)
    frame = zeros((2 * n + m, len(constants)), c)
    for f, j in enumerate(map_.free):
        # a of the frame are the free constants themselves; B, x and y stay: β is constant
        frame.value[n + f, j] = c.mpf(1)
    return Inputs(constants, frame, by)


def _numbers(
    motion: Motion, map_: ConstantsToState, means: MeanMatrix | None, group: Inputs, wanted: frozenset[str],
    found: _Collected,
) -> None:  # fmt: skip
    """Actions, frequencies, periods, turning points and constants."""
    solution = map_.source.solution
    if "constants" in wanted:
        for j, name in enumerate(map_.variables.constants):
            found.put("constants", name, group, [group.by[j]])
    if "actions" in wanted:
        for name in motion.actions:
            if name in solution.coordinates:
                i = solution.coordinates.index(name)
                if has_means(map_.parts[i]):
                    found.put("actions", name, group, [action_by(map_, i) @ group.by])
                continue
            momentum = solution.system.coordinate(name).momentum.name
            found.put("actions", name, group, [group.by[map_.variables.constants.index(momentum)]])
    for quantity in ("frequencies", "periods"):
        if quantity in wanted:
            for name in getattr(motion, quantity):
                row = _frequency_by(map_, means, name)
                if row is None:
                    found.refuse(quantity, name, group, NOT_ALONE)
                    continue
                row = row @ group.by
                if quantity == "periods":
                    row = _period_by(map_, means, name, row)
                found.put(quantity, name, group, [row])
    if "turning_points" in wanted:
        for i, name in enumerate(solution.coordinates):
            if name in motion.turning_points:
                _turning(map_, i, name, group, found)


def _frequency_by(map_: ConstantsToState, means: MeanMatrix | None, name: str) -> Bounded | None:
    if means is None:
        return None
    k, direction = _position(map_, name)
    row = means.frequencies_by()[k]
    return row if direction > 0 else -row


def _period_by(map_: ConstantsToState, means: MeanMatrix | None, name: str, row: Bounded) -> Bounded:
    """d(2π/|Ω|) = −2π dΩ/(Ω |Ω|)."""
    k, direction = _position(map_, name)
    if means is None:
        return row
    Ω = means.frequencies[k]
    value = Ω.value[()] * direction
    # the error of Ω goes in twice, as Ω² stands below
    factor = -2 * map_.context.pi / (value * abs(value))
    uncertainty = abs(float(factor)) * 2 * float(Ω.error) / abs(float(value))
    return Bounded(row.value * factor, abs(float(factor)) * row.error + uncertainty * row.size)


def _position(map_: ConstantsToState, name: str) -> tuple[int, int]:
    """Row of a coordinate in K, and the sign of its action."""
    solution = map_.source.solution
    if name in solution.coordinates:
        k = solution.coordinates.index(name)
        part = map_.parts[k]
        return k, part.coordinate_motion.direction if isinstance(part, CycleVariations) else 1
    others = [q.name for q in solution.system.coordinates if q.name not in solution.coordinates]
    return len(map_.parts) + others.index(name), 1


def _turning(map_: ConstantsToState, i: int, name: str, group: Inputs, found: _Collected) -> None:
    part = map_.parts[i]
    # from rest turning points grow like √J: no derivative
    if isinstance(part, RestVariations):
        found.refuse("turning_points", name, group, SQUARE_ROOT, pair=True)
        return
    if isinstance(part, CycleVariations):
        ends: tuple[list[Mpf] | None, list[Mpf] | None] = part.ends or (None, None)
    else:
        ends = _open_ends(part)
    rows = [None if end is None else Bounded.exact(np.array(end, dtype=object)) @ group.by for end in ends]
    if any(row is not None for row in rows):
        found.put("turning_points", name, group, rows)


def _open_ends(part: OpenVariations) -> tuple[list[Mpf] | None, list[Mpf] | None]:
    end_map = part.ahead.branch.end_map
    if not end_map.turning:
        return None, None
    return (part.ahead.start, None) if end_map.side > 0 else (None, part.ahead.start)


def _times(motion: Motion, t: object) -> tuple[tuple[int, ...] | None, Reals | None, Sequence[Callable[[int], Mpf]]]:
    return ((), None, [to_bits(motion.separated.t0)]) if t is None else read_times(t)


def _angles(
    motion: Motion, map_: ConstantsToState, means: MeanMatrix | None, group: Inputs, t: object, found: _Collected
) -> None:
    """θ(t) = θ(t₀) + Ω (t − t₀)."""
    if means is None:
        return
    shape, floats, exact = _times(motion, t)
    c, bits = map_.context, map_.context.prec
    rules = exact if floats is None else [exactly(float(x)) for x in floats]
    # θ(t) is linear in t: its derivative by Ω grows with the time, and so does the error of that
    gone = [c.convert(rule(bits)) - to_bits(map_.source.t0)(bits) for rule in rules]
    rows = angles_by(map_, means)
    for name in motion.frequencies:
        if group.by_frame is None:
            found.refuse("angles", name, group, DEPENDENT)
        elif name not in rows:
            found.refuse("angles", name, group, SQUARE_ROOT)
        elif not differentiable_angles(map_):
            found.refuse("angles", name, group, NOT_ALONE)
        else:
            rate = required(_frequency_by(map_, means, name))
            begin, slope = rows[name] @ group.by_frame, rate @ group.by
            grown = [Bounded(slope.value * x, slope.error * abs(float(x))) for x in gone]
            found.put("angles", name, group, [stacked([begin + g for g in grown])], shape)


def _state(
    motion: Motion,
    map_: ConstantsToState,
    users: UsersCoordinates | None,
    varied: frozenset[str],
    t: object,
    found: _Collected,
) -> None:
    """Q and p at times."""
    shape, floats, exact = _times(motion, t)
    main, by, frames = matrices(motion, floats, exact, parameters="parameters" in varied)
    names = users.names if users is not None else [q.name for q in map_.source.solution.system.coordinates]
    columns = _of_the_start(names, map_.variables.parameters, varied, main, by)
    if "constants" in varied:
        group = _constants(map_)
        known = [frame for frame in frames if frame is not None]
        rows = None
        if group.by_frame is not None and len(known) == len(frames):
            rows = stacked([frame.state @ group.by_frame[: 2 * len(names)] for frame in known])
        columns.append((group, rows))
    _put_states(found, names, columns, shape)


__all__ = ["derivatives_of", "transition_matrix"]

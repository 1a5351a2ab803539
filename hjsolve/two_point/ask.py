"""two_point(): which method answers."""

from __future__ import annotations

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.precision import one_at_a_time
from hjsolve.solution.quadratures import Solution
from hjsolve.two_point.asked.answers import Connections
from hjsolve.two_point.asked.central_force import attraction_of, central_force_of
from hjsolve.two_point.asked.question import read_question
from hjsolve.two_point.central.connections import joined_about_a_centre
from hjsolve.two_point.kepler.arrays import ConnectionTable, has_arrays, table_of_conics
from hjsolve.two_point.kepler.connections import is_attraction, joined_by_conics
from hjsolve.two_point.linear import joined_linearly, linear_forces
from hjsolve.two_point.one_freedom.connections import joined_on_a_line, shell_of
from hjsolve.two_point.search.searched import joined_by_search


@one_at_a_time
def two_point(
    solution: Solution, *, q0: object, q1: object, time: object, turns: object, parameters: object, digits: int,
    budget: float,
) -> Connections | ConnectionTable:  # fmt: skip
    """Find every motion that joins two places in a time.

    Args:
        solution, q0, q1, time, turns, parameters, digits, budget: as of ``Solution.two_point``, which says the rest.

    Raises:
        InvalidInputError: see there.
    """
    budget = arguments.seconds(budget, "budget")
    system = solution.system if solution.chart is None else solution.chart.original
    attraction = attraction_of(system)
    if has_arrays(q0, q1, time):
        if attraction is None:
            raise InvalidInputError(
                "two_point: arrays are taken for the Kepler problem only; ask for one pair at a time"
            )
        return table_of_conics(solution, attraction, (q0, q1, time, turns), parameters)
    question, values = read_question(solution, q0, q1, time, turns, parameters, arguments.digits(digits))
    if attraction is not None and is_attraction(attraction, values):
        return joined_by_conics(attraction, question, values)
    forces = linear_forces(question.system)
    if forces is not None:
        return joined_linearly(forces, question, values)
    force = central_force_of(system)
    if force is not None:
        found = joined_about_a_centre(force, question, values, budget)
        if found is not None:
            return found
    shell = shell_of(question)
    if shell is not None:
        found = joined_on_a_line(question, values, shell, budget)
        if found is not None:
            return found
    return joined_by_search(question, values)

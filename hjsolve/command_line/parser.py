"""What the command line takes: each command with its arguments, its help, its examples. Only argparse is imported."""

from __future__ import annotations

import argparse
from typing import TypeAlias

from hjsolve._version import __version__
from hjsolve.command_line.examples import EXAMPLES
from hjsolve.command_line.strict_arguments import StrictParser

_ABOUT = """\
Decide whether a mechanical system separates in its coordinates, solve it by quadratures
(Hamilton-Jacobi), and compute results with error bounds."""

_SYSTEMS = """\
SYSTEM is an entry of the catalog (see `hjsolve catalog`), or the path of a .toml file of the same
format or of a scene. Without SYSTEM, write the kinetic and potential energy on the command line. In
formulas, dot(q), q' or qdot is the velocity of q and ** or ^ is a power; the usual functions and pi
are known; every other name must be a coordinate or a parameter."""

_STATUS = """\
exit status:
  0  an answer
  1  the system does not separate in these coordinates (the answer is the obstruction)
  2  bad input: one line says what, where, and what to write instead
  3  undecided, or a number that did not converge"""


# -------------------------------------------------------------------------------- the arguments
_Commands: TypeAlias = "argparse._SubParsersAction[StrictParser]"


def command_parser() -> argparse.ArgumentParser:
    """Build the argument parser."""
    top = StrictParser(
        prog="hjsolve",
        allow_abbrev=False,
        description=_ABOUT,
        epilog=f"{EXAMPLES['']}\n\n{_STATUS}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"hjsolve {__version__}")
    kinds: _Commands = top.add_subparsers(
        dest="command", required=True, metavar="COMMAND", title="commands", parser_class=StrictParser
    )
    _add_check(kinds)
    _add_solve(kinds)
    _add_coordinates(kinds)
    _add_verify(kinds)
    _add_bracket(kinds)
    _add_integral(kinds)
    _add_canonical(kinds)
    _add_action(kinds)
    _add_loop(kinds)
    _add_impact(kinds)
    _add_forces(kinds)
    _add_contact(kinds)
    _add_motion(kinds)
    _add_two_point(kinds)
    _add_report(kinds)
    _add_explore(kinds)
    _add_cost(kinds)
    _add_sweep(kinds)
    _add_catalog(kinds)
    _add_completion(kinds)
    _add_setup(kinds)
    return top


def _add(kinds: _Commands, name: str, summary: str, about: str) -> argparse.ArgumentParser:
    return kinds.add_parser(
        name,
        help=summary,
        allow_abbrev=False,
        description=about,
        epilog=f"{EXAMPLES[name]}\n\n{_STATUS}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _on_a_system(kinds: _Commands, name: str, summary: str, about: str) -> argparse.ArgumentParser:
    command = _add(kinds, name, summary, f"{about}\n\n{_SYSTEMS}")
    _system_arguments(command)
    return command


def _add_check(kinds: _Commands) -> None:
    about = (
        "Decide whether a system separates in its coordinates and print the evidence: the reduction, the\n"
        "conditions, Stäckel and Liouville forms; or the obstruction with a witness."
    )
    check = _on_a_system(kinds, "check", "does the system separate, and why?", about)
    _budget_argument(check)


def _add_solve(kinds: _Commands) -> None:
    about = (
        "Solve a system by quadratures and print Hamilton's characteristic function W, the momenta, the\n"
        "time law and the orbit equations."
    )
    solve = _on_a_system(kinds, "solve", "W, momenta, time law and orbit equations", about)
    _find_argument(solve)
    _budget_argument(solve)
    solve.add_argument(
        "--closed", action="store_true",
        help="begin with closed forms: the integrals evaluated, for each regime, and verified (takes seconds)",
    )  # fmt: skip


def _add_coordinates(kinds: _Commands) -> None:
    about = (
        "Find every orthogonal coordinate system in which a system given in Cartesian coordinates of the plane\n"
        "or of space separates, with centres, axes and foci; and normal modes where T and V are quadratic with\n"
        "constant coefficients. Status 1: there are none."
    )
    coordinates = _on_a_system(kinds, "coordinates", "in which coordinates does it separate?", about)
    own = coordinates.add_argument_group("coordinates of your own, in place of a search")
    _many(own, "--place", "EQUATION", 'an old coordinate in the new ones, e.g. "x = r*cos(phi)" (repeat, one for each)')
    _many(own, "--new", '"NAME: DOMAIN"', 'e.g. "r: 0 < r", "phi: angle" (repeat)')


def _add_verify(kinds: _Commands) -> None:
    about = (
        "Decide whether Hamilton's characteristic function W(q, constants) or principal function S(q, constants, t)\n"
        "that you type is a complete integral: it solves the Hamilton-Jacobi equation, and its constants are\n"
        "independent. integral(f, q) is an antiderivative, integral(f, q, a) one from a to q. Status 1: it is not,\n"
        "with a witness. Status 3: neither was proved."
    )
    verify = _on_a_system(kinds, "verify", "is this W or S a complete integral?", about)
    verify.add_argument("-W", metavar="FORMULA", help="Hamilton's characteristic function W(q, constants)")
    verify.add_argument("-S", metavar="FORMULA", help="Hamilton's principal function S(q, constants, t), in place of W")
    verify.add_argument("--F4", metavar="FORMULA", help="a function of the momenta, F4(p, constants), in place of W")
    _constant_argument(verify)
    verify.add_argument("--energy", metavar="FORMULA", help="with -W or --F4, the energy in the constants (default: E)")
    _budget_argument(verify, "for each proof")
    _json_argument(verify)
    _motion_arguments(verify)


def _add_bracket(kinds: _Commands) -> None:
    about = (
        "Print the Poisson brackets of every two of several functions of coordinates, momenta p_q or velocities,\n"
        "and t; H is the Hamiltonian. Status 0: all of them are proved to vanish, or are written down."
    )
    command = _on_a_system(kinds, "bracket", "Poisson brackets of functions", about)
    _of_argument(command)
    _budget_argument(command, "for each proof")
    _json_argument(command)


def _add_integral(kinds: _Commands) -> None:
    about = (
        "Decide whether functions of coordinates, momenta p_q or velocities, and t are constant along every motion,\n"
        "(f, H) + df/dt = 0; of several integrals, whether they are in involution. Status 1: one of them is not, with\n"
        "a witness. Status 3: neither was proved."
    )
    command = _on_a_system(kinds, "integral", "is this an integral of the motion?", about)
    _of_argument(command)
    _budget_argument(command, "for each proof")
    _json_argument(command)


def _add_action(kinds: _Commands) -> None:
    about = "Compute Hamilton's integral of L dt along a path that you type; it need not be a motion."
    command = _on_a_system(kinds, "action", "the integral of L dt along a path", about)
    _many(command, "--path", "EQUATION", 'e.g. "x = t**2" (repeat, one for each)')
    command.add_argument("--between", metavar="T:T", help="the first and the last time, e.g. 0:1")
    command.add_argument("--digits", type=int, default=15, metavar="N", help="digits of the value (default 15)")
    _json_argument(command)


def _add_loop(kinds: _Commands) -> None:
    about = (
        "Follow a closed curve of states q(s), p(s), 0 <= s <= 2*pi, and print the integral of p dq along it at\n"
        "several times: it stays, as Poincare proved. Status 1: the values do not agree within their errors."
    )
    command = _on_a_system(kinds, "loop", "the integral of p dq along a closed curve as it moves", about)
    _find_argument(command)
    for option, what in (("--q", "coordinates"), ("--momentum", "momenta")):
        _many(command, option, "NAME=FORMULA", f"{what} of the curve, e.g. x=cos(s)")
    command.add_argument("--times", default="0,1", metavar="TIMES", help="start:stop:count, or a list (default 0,1)")
    _json_argument(command)


def _add_impact(kinds: _Commands) -> None:
    about = (
        "Compute an impact: constraints appear suddenly and change the velocities by unknown impulses. Prints the\n"
        "impulses, the velocities, momenta and energies before and after, their balance, and the system if the\n"
        "constraints last. All results are exact."
    )
    command = _on_a_system(kinds, "impact", "an impact with an unknown impulse", about)
    _motion_arguments(command)
    _many(command, "--meets", "EQUATION", 'what holds just after, e.g. "dot(y) = 0" or "x**2 + y**2 = 1" (repeat)')
    _many(
        command,
        "--restitution",
        "E",
        "coefficient of restitution, 0 (default) to 1; one for all constraints or one for each",
    )
    _json_argument(command)


def _add_forces(kinds: _Commands) -> None:
    about = (
        "Write Lagrange's equations with multipliers, and the constraint forces and accelerations as functions of the\n"
        "state. The constraints need not be integrable."
    )
    command = _on_a_system(kinds, "forces", "constraint forces by Lagrange's multipliers", about)
    _holds_argument(command, '"dot(x)*cos(theta) + dot(y)*sin(theta) = 0"')
    _json_argument(command)


def _add_contact(kinds: _Commands) -> None:
    about = (
        "Find when a body leaves a surface that pushes it and cannot pull: the constraint force as a formula, the\n"
        "instant at which it changes sign, and the state there."
    )
    command = _on_a_system(kinds, "contact", "when a body leaves a one-sided constraint", about)
    _motion_arguments(command)
    _holds_argument(command, '"x**2 + y**2 >= 1" of the outside of a circle; "=" lasts on both sides')
    command.add_argument("--until", metavar="T", help="the last time of interest (default: no limit)")
    command.add_argument("--digits", type=int, default=15, metavar="N", help="digits of the time (default 15)")
    _json_argument(command)


def _holds_argument(command: argparse.ArgumentParser, example: str) -> None:
    command.add_argument(
        "--holds", action="append", default=[], metavar="CONSTRAINT", help=f"a constraint, e.g. {example} (repeat)"
    )


def _of_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--of", action="append", default=[], metavar="FORMULA", help="a function, e.g. p_theta or H (repeat)"
    )


def _json_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", action="store_true", help="the answer as one JSON object")


def _add_canonical(kinds: _Commands) -> None:
    about = (
        "Decide whether a map to new coordinates and momenta is canonical, by its brackets; find its valence, the\n"
        "generating functions and what is added to the Hamiltonian. Or give one generating function, and have the\n"
        "map. The old variables are q and p, or those of --pair. Status 1: it is not canonical, with a witness."
    )
    canonical = _add(kinds, "canonical", "is this map canonical? with its generating functions", about)
    canonical.add_argument(
        "formula", nargs="*", metavar="EQUATION", help='the coordinates first, then their momenta: "Q = atan(q/p)" …'
    )
    _many(canonical, "--pair", '"q: p"', "an old coordinate and its momentum (repeat)")
    _many(canonical, "--domain", '"NAME: DOMAIN"', 'where an old variable lies, e.g. "p: 0 < p < pi/2" (repeat)')
    _constant_argument(canonical)
    canonical.add_argument("--hamiltonian", metavar="FORMULA", help="H(q, p, t), where the new one is wanted")
    canonical.add_argument(
        "--generating", metavar="EQUATION", help='in place of the map: "F2 = …", of kind F1(q, Q) to F4(p, P)'
    )
    _many(canonical, "--new", '"Q: P"', "with --generating, the new pairs (repeat)")
    _budget_argument(canonical, "for each proof")
    _json_argument(canonical)


def _constant_argument(command: argparse.ArgumentParser) -> None:
    _many(
        command,
        "--constant",
        'NAME or "NAME: DOMAIN"',
        'a constant in the formulas, e.g. E, or "a: 0 < a" where they hold on one side only (repeat)',
    )


def _add_report(kinds: _Commands) -> None:
    about = (
        "Write a report: the system and its reduction, whether and why it separates, W, time law and orbit, and\n"
        "one motion with figures and results. The suffix of FILE chooses the format: .html .pdf .md .json .txt\n"
        ".tex"
    )
    report = _on_a_system(kinds, "report", "all of that in a file, with figures and results", about)
    _find_argument(report)
    _budget_argument(report)
    report.add_argument(
        "-o", "--output", required=True, metavar="FILE", help='file to write (replaced if it exists), or "-" to print'
    )
    report.add_argument(
        "--cost", action=argparse.BooleanOptionalAction, default=False,
        help="add a section that measures accuracy against time; takes three seconds (default: no)",
    )  # fmt: skip
    report.add_argument(
        "--live", action="store_true",
        help="begin the .html with sliders and a moving point, for motions that librate or rotate",
    )  # fmt: skip
    _many(
        report,
        "--slider",
        "NAME[=LOW:HIGH]",
        "with --live: a slider for this constant or parameter, over this range or as far as possible (repeat)",
    )
    report.add_argument(
        "--brief", action="store_true",
        help="leave out closed forms, map of all motions and surface of section, which take longest",
    )  # fmt: skip
    report.add_argument("--paper", metavar="A4|Letter", help="paper size, also of a printed .html (default A4)")
    report.add_argument("--format", choices=["html", "md", "json", "txt", "tex"], help='format of "-o -" (default txt)')
    _motion_arguments(report)
    report.add_argument("--digits", type=int, default=15, metavar="N", help="digits of the results (default 15)")


def _find_argument(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--find", action="store_true",
        help="if these coordinates do not separate, use normal modes or the simplest coordinates found",
    )  # fmt: skip


def _budget_argument(command: argparse.ArgumentParser, what: str = "for reading the system and deciding") -> None:
    command.add_argument(
        "--budget", type=float, default=60.0, metavar="S",
        help=f"seconds allowed {what}; after that the answer is: not decided (default 60)",
    )  # fmt: skip


def _motion_arguments(command: argparse.ArgumentParser) -> None:
    motion = command.add_argument_group("the motion (default: that of the catalog entry)")
    motion.add_argument("--motion", default="default", metavar="NAME", help="another motion of the catalog entry")
    for option, what in (
        ("--q", "initial coordinates, e.g. r=1 theta=0, or r=1,theta=0"),
        ("--velocity", "initial velocities, e.g. r=0 theta=1.2"),
        ("--momentum", "initial momenta, in place of velocities"),
    ):
        _many(motion, option, "NAME=VALUE", what)


def _add_motion(kinds: _Commands) -> None:
    about = (
        "Compute a motion and print its results (periods, actions, turning points, ...), or with --times its\n"
        "states, as CSV or JSON. Each value has a bound on its error. A scene is computed at its own times."
    )
    motion = _on_a_system(kinds, "motion", "results of a motion, and its state at given times", about)
    _find_argument(motion)
    _motion_arguments(motion)
    motion.add_argument("--times", metavar="TIMES", help="start:stop:count, both ends included, or a list: 0,1/2,1e3")
    motion.add_argument("--digits", type=int, default=15, metavar="N", help="digits of the results (default 15)")
    motion.add_argument("--json", action="store_true", help="print results and states as one JSON object")


def _add_two_point(kinds: _Commands) -> None:
    about = (
        "Find the motions that go from one place to another in a given time, with S, the momenta at both ends and\n"
        "the conjugate points. The answer says whether these are proved to be all.\n\n" + _SYSTEMS
    )
    command = _add(kinds, "two-point", "the motions from one place to another in a given time", about)
    _system_arguments(command)
    _find_argument(command)
    places = command.add_argument_group("two places and a time")
    for option, name, what in (("--from", "start", "place at time 0"), ("--to", "goal", "place after the time")):
        _many(places, option, "NAME=VALUE", f"{what}, e.g. r=1 theta=0", dest=name)
    places.add_argument("--time", metavar="T", help="time between the two places, > 0")
    places.add_argument("--turns", default="0", metavar="N:N", help="whole turns: 0:3 or 0,2 (default 0)")
    _budget_argument(command, "for the proof that these are all")
    command.add_argument("--digits", type=int, default=15, metavar="N", help="digits of the motions (default 15)")
    command.add_argument("--json", action="store_true", help="everything as one JSON object")


def _add_explore(kinds: _Commands) -> None:
    about = (
        "Open an interactive page in the browser. Type a system and see at once whether it separates, drag the\n"
        "initial point in the phase plane, read each result with its error, and download a report or a scene.\n"
        "The page is served on this machine only (127.0.0.1), until you press Ctrl-C (extra explore)."
    )
    explore = _add(kinds, "explore", "an interactive page: type a system, drag its initial point", about)
    explore.add_argument("system", nargs="?", metavar="SYSTEM", help="catalog id, or .toml file of an entry or a scene")
    explore.add_argument("--port", type=int, default=0, metavar="N", help="port of the page (default: any free port)")
    explore.add_argument("--no-browser", action="store_true", help="print the address and do not open a browser")
    explore.add_argument("--seconds", type=float, default=20.0, metavar="S", help="limit of a computation (default 20)")
    explore.add_argument("--memory", type=int, default=1024, metavar="MB", help="limit of a computation (default 1024)")


def _add_cost(kinds: _Commands) -> None:
    about = (
        "Measure accuracy against time: all methods that apply compute the same quantities, hjsolve's own and, for\n"
        "states, numerical integrators. Errors are true errors, measured against a reference with more digits from\n"
        "an independent method."
    )
    cost = _on_a_system(kinds, "cost", "measure accuracy against computing time", about)
    _motion_arguments(cost)
    cost.add_argument(
        "--digits", metavar="N,N,…", help="digits beyond double precision (default 20,30,50, with 30 seconds 100 too)"
    )
    cost.add_argument("--seconds", type=float, default=20.0, metavar="S", help="time allowed in all (default 20)")
    cost.add_argument("--no-rivals", action="store_true", help="skip DOP853 and heyoka")
    cost.add_argument("-o", "--output", metavar="FILE", help="document: .html .pdf .md .json .txt .tex, or .svg")


def _add_sweep(kinds: _Commands) -> None:
    about = (
        "Compute the orbits that the table [sweep] of a scene declares: actions, frequencies, angles and the\n"
        "like, each with its error, and a status for every orbit. The output is a folder of Parquet files,\n"
        "written part by part. Rerun the same command to resume an interrupted run: parts that are\n"
        "complete and unchanged are kept, the others are computed."
    )
    sweep = _add(kinds, "sweep", "many orbits into Parquet files, resumable", about)
    sweep.add_argument("scene", metavar="SCENE", help="a scene with a table [sweep], a .toml file")
    sweep.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where to write, e.g. orbits.parquet")
    sweep.add_argument("--threads", type=int, metavar="N", help="threads (default: all cores of this process)")
    sweep.add_argument("--scheduler", metavar="ADDRESS", help="of a dask scheduler, tcp://…, in place of threads")
    sweep.add_argument("--chunk", type=int, metavar="N", help="orbits of one file (default: what the scene says)")
    sweep.add_argument("--verify", action="store_true", help="compute nothing; examine every part of a finished sweep")
    sweep.add_argument("--quiet", action="store_true", help="no progress bar")


def _add_catalog(kinds: _Commands) -> None:
    about = "List the catalog of mechanical systems, search it, show one entry, or check a file of your own."
    catalog = _add(kinds, "catalog", "the systems that come with hjsolve", about)
    catalog.add_argument(
        "action", nargs="?", choices=["list", "show", "search", "check"], default="list",
        help="what to do (default: list)",
    )  # fmt: skip
    catalog.add_argument(
        "entry", nargs="?", metavar="ENTRY", help="an id for show, words for search, a .toml file for check"
    )
    filters = catalog.add_argument_group("which entries to list")
    filters.add_argument("--separable", action="store_true", help="those that are solved: separable and extended")
    filters.add_argument("--kind", choices=["separable", "extended", "refused", "outside"], help="those of one kind")
    filters.add_argument("--book", metavar="ROW", help="those that are one row of docs/book.md, e.g. C28")


def _add_completion(kinds: _Commands) -> None:
    about = "Print a script that completes commands, options and the ids of the catalog in a shell (extra completion)."
    completion = _add(kinds, "completion", "completion of commands in your shell", about)
    completion.add_argument("shell", choices=["bash", "zsh", "tcsh", "fish", "powershell"], help="the shell")


def _add_setup(kinds: _Commands) -> None:
    about = "Compile the kernels of ensembles now rather than at their first use; once per installation (extra fast)."
    _add(kinds, "setup", "compile the kernels of ensembles, once", about)


def _many(where: argparse._ActionsContainer, option: str, metavar: str, what: str, dest: str | None = None) -> None:
    """Add an option that may be repeated."""
    where.add_argument(option, action="append", default=[], metavar=metavar, help=what, dest=dest)


def _system_arguments(command: argparse.ArgumentParser) -> None:
    command.add_argument("system", nargs="?", metavar="SYSTEM", help="catalog id, or .toml file of an entry or a scene")
    _many(command, "--effect", "NAME", "switch on an effect of the entry (repeat)")
    own = command.add_argument_group("a system of your own")
    own.add_argument(
        "--coordinate", action="append", default=[], metavar='"NAME: DOMAIN"',
        help='e.g. "x: line", "theta: angle", "r: 0 < r", "x: -a < x < a" (repeat)',
    )  # fmt: skip
    own.add_argument(
        "--function", action="append", default=[], metavar='"NAME(COORDINATE)"',
        help='a function that T or V leaves undetermined, e.g. "v1(r)" (repeat)',
    )  # fmt: skip
    own.add_argument("-T", "--kinetic", metavar="FORMULA", help="kinetic energy, e.g. m/2*dot(x)**2")
    own.add_argument("-V", "--potential", metavar="FORMULA", help="potential energy (default 0)")
    own.add_argument(
        "--hamiltonian", metavar="FORMULA",
        help="instead of --kinetic and --potential: H with p_ before each coordinate, e.g. p_x**2/(2*m) + k*x**2/2",
    )  # fmt: skip
    _many(
        own,
        "--constraint",
        "EQUATION",
        'holonomic, or linear in the velocities and integrable, e.g. "x**2 + y**2 = l**2" (repeat)',
    )
    own.add_argument("--title", metavar="TEXT", help="what the system is called in the output")
    _many(
        command,
        "--parameter",
        "NAME[=VALUE][:SIGN]",
        "a parameter of your own system, e.g. m=1:positive, or another value for one of the entry (repeat)",
    )

"""The verb of this package: write a report to a file, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from hjsolve import catalog
from hjsolve.arguments import described, refuse_unused, with_known_names
from hjsolve.display.progress import Progress
from hjsolve.display.visible_text import visible
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.extended.linear_hamiltonian import LinearHamiltonian
from hjsolve.precision import one_at_a_time
from hjsolve.reports.content import Material, Subject, document, gather, initial_of
from hjsolve.reports.document import Document, files, pdf
from hjsolve.reports.document.files import SUFFIXES, checked_path, checked_title, readable_errors
from hjsolve.reports.formats.html import html_page
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.latex_document import tex
from hjsolve.reports.formats.markdown import markdown_page
from hjsolve.reports.formats.text import text_page
from hjsolve.reports.sections.outside import outside_document
from hjsolve.scenes import Scene

_WRITERS: Mapping[str, Callable[[Document], str]] = {
    ".html": html_page,
    ".pdf": html_page,
    ".md": markdown_page,
    ".json": json_text,
    ".txt": text_page,
    ".tex": tex,
}


PAPERS = ("A4", "Letter")
_PRINTED = (".html", ".pdf")


@dataclass(frozen=True)
class Sheet:
    """What a report is called, and the paper it is printed on.

    Attributes:
        title: in place of the subject's own; empty for that.
        paper: one of ``PAPERS``, or None.
    """

    title: str = ""
    paper: str | None = None

    def on_paper(self, page: str, target: Path) -> str:
        """Return a page with the size of its paper; a PDF has one always.

        Args:
            page: HTML with the style sheet of reports.
            target: the file that is wanted.
        """
        paper = self.paper or (PAPERS[0] if target.suffix.lower() == ".pdf" else None)
        return page if paper is None else page.replace("@page{", f"@page{{size:{paper};", 1)


PLAIN = Sheet()
"""The subject's own title, on the paper of its kind of file."""


def checked_sheet(title: str, paper: object, target: Path) -> Sheet:
    """Check title and paper of a report.

    Args:
        title, paper: as in ``report``.
        target: the file that is wanted.

    Raises:
        InvalidInputError: not a title that can be printed, another paper, or paper for a file that is not printed.
    """
    known = {name.lower(): name for name in PAPERS}
    if paper is not None and (not isinstance(paper, str) or paper.lower() not in known):
        raise InvalidInputError(f'paper: write "{PAPERS[0]}" or "{PAPERS[1]}", not {described(paper)}')
    if paper is not None and target.suffix.lower() not in _PRINTED:
        raise InvalidInputError(f"paper: {target.suffix} files have no pages; write .pdf or .html, or leave paper out")
    return Sheet(checked_title(title), None if paper is None else known[str(paper).lower()])


@with_known_names('report("kepler-planar", "kepler.html", digits=15)')
@one_at_a_time
def report(
    subject: Subject | Scene | LinearHamiltonian,
    path: str | Path,
    *,
    initial: Mapping[str, object] | None = None,
    motion: str = "default",
    digits: int = 15,
    cost: bool | float = False,
    live: bool = False,
    sliders: Mapping[str, tuple[float, float] | None] | None = None,
    brief: bool = False,
    title: str = "",
    paper: str | None = None,
) -> Path:
    """Write a report about a system, a verdict, a solution or a motion.

    What can be told is told: formulas always; numbers and drawings where there are initial data, which a catalog
    entry brings.

    Args:
        subject: a ``System``, ``Separation``, ``Obstruction``, ``Undecided``, ``Solution``, ``Motion``, ``Scene`` or
            ``LinearHamiltonian``; a catalog id, or the path of a TOML entry.
        path: where to write; the suffix chooses the format: .html, .pdf, .md, .json, .txt or .tex. An existing file is
            replaced, and only once the new one is complete.
        initial: keyword arguments for ``solution.motion``, in place of the catalog's initial data.
        motion: which of the catalog entry's motions.
        digits: of the numbers.
        cost: whether the report has a section that measures what accuracy costs, in 3 seconds; or the seconds it may
            take, at most 10.
        live: whether the page has sliders for the constants of the motion and a point that moves (.html only; for a
            motion whose separated coordinates all librate or rotate). It is one file that asks nothing of the net.
        sliders: constants or parameters that a live page is to have sliders for, each with its range (low, high), or
            None for as far as possible; sliders next to them, up to four in all, are constants.
        brief: whether closed forms, the map of all motions and surfaces of section are left out, which take most of
            the time.
        title: in place of the system's own.
        paper: ``A4`` or ``Letter`` for .pdf and .html; None is A4 in a PDF, and what the browser's menu says otherwise.

    Returns:
        The path written.

    Raises:
        InvalidInputError: another suffix, a path that cannot be written, or a subject that cannot be reported. Where
            the initial data give no motion (a forbidden one, or a place outside the domain), the report is written all
            the same, with the verdict and what is wrong with the motion.
        NotConvergedError: a number fell short of the digits asked; the report is written all the same, and says which.

    Example:
        >>> report("kepler-planar", "kepler.html")  # doctest: +SKIP
        PosixPath('kepler.html')
    """
    target = checked_path(path, (".html",) if live else SUFFIXES)
    sheet = checked_sheet(title, paper, target)
    if sliders and not live:
        raise InvalidInputError("sliders: only a live report has them; write live=True")
    own = {"initial": initial is not None, "motion": motion != "default", "digits": digits != 15}
    if isinstance(subject, Scene):
        refuse_live(live)
        refuse_unused({**own, "brief": brief}, "a scene says everything itself")
        return save_scene(subject, target, cost, sheet=sheet)
    if (outside := outside_entry(subject)) is not None:
        refuse_live(live)
        refuse_unused({**own, "cost": bool(cost), "brief": brief}, "an entry not given by T and V has no motions")
        return write_document(outside_document(outside), target, sheet=sheet)
    if isinstance(subject, LinearHamiltonian) or (
        isinstance(subject, str | Path) and catalog.hamiltonian(subject) is not None
    ):
        refuse_live(live)
        refuse_unused({"cost": bool(cost), "brief": brief}, "H(q, p) is linear in p, and all of it is closed forms")
        return save_hamiltonian(subject, target, initial=initial, motion=motion, digits=digits, sheet=sheet)
    material = gather(subject, initial=initial, motion=motion, digits=digits)
    return save(material, target, cost, live=live, sliders=sliders, brief=brief, sheet=sheet)


def refuse_live(live: bool) -> None:
    """Refuse a live report of what is not the motion of a system.

    Raises:
        InvalidInputError: it is.
    """
    if live:
        raise InvalidInputError("live: only the report of one motion can be live, not this; leave live=True out")


def save_scene(
    scene: Scene, target: Path, cost: bool | float = False, progress: Progress | None = None, *,
    sheet: Sheet = PLAIN,
) -> Path:  # fmt: skip
    """Run a scene and write its report.

    Args:
        target: a path that ``checked_path`` has passed.
        cost, progress: as in ``sections.cost.with_cost``.
        sheet: its title, in place of the scene's own, and its paper.

    Returns:
        The path.

    Raises:
        NotSeparableError: the scene cannot be solved by quadratures and does not ask for an integrator.
        InvalidInputError: the file cannot be written.
    """
    from hjsolve.reports.sections.cost import with_cost
    from hjsolve.reports.sections.scene import scene_document

    return write_document(with_cost(scene_document(scene.run()), scene, cost, progress), target, sheet=sheet)


def save_hamiltonian(
    subject: LinearHamiltonian | str | Path,
    target: Path,
    *,
    initial: Mapping[str, object] | None,
    motion: str,
    digits: int,
    sheet: Sheet = PLAIN,
) -> Path:
    """Solve H = a(q) p + b(q) and write its report.

    Args:
        subject: the Hamiltonian, or a catalog entry that gives one.
        target: a path that ``checked_path`` has passed.
        initial: keyword arguments for ``problem.motion``, in place of the catalog's initial data.
        motion: which of the entry's motions.
        sheet: its title, in place of the entry's own, and its paper.

    Returns:
        The path.

    Raises:
        InvalidInputError: no such motion, or the file cannot be written.
    """
    from hjsolve.reports.sections.linear_hamiltonian import hamiltonian_document

    entry = None if isinstance(subject, LinearHamiltonian) else catalog.describe(subject)
    problem = required(subject if isinstance(subject, LinearHamiltonian) else entry.hamiltonian if entry else None)
    data, about = initial_of(entry, initial, motion)
    started = problem.motion(**data, digits=digits) if data else None
    meanings, summary = (entry.meanings, entry.summary) if entry else ({}, "")
    return write_document(hamiltonian_document(problem, meanings, summary, started, about, entry), target, sheet=sheet)


def save(
    material: Material, target: Path, cost: bool | float = False, progress: Progress | None = None, *,
    live: bool = False, sliders: Mapping[str, tuple[float, float] | None] | None = None, brief: bool = False,
    sheet: Sheet = PLAIN,
) -> Path:  # fmt: skip
    """Write what was gathered.

    Args:
        material: what there is to tell.
        target: a path that ``checked_path`` has passed.
        cost, progress: as in ``sections.cost.with_cost``.
        live, sliders, brief: as in ``report``.
        sheet: its title, in place of the system's own, and its paper.

    Returns:
        The path.

    Raises:
        InvalidInputError: the file cannot be written, or there is no motion that could be live; the motion is refused,
            and the report without it is written all the same.
        NotConvergedError: a number fell short; the report is written all the same.
    """
    from hjsolve.reports.sections.cost import with_cost

    content = document(material, brief=brief)
    if material.motion is not None:
        content = with_cost(content, material.motion, cost, progress)
    if live and material.motion is None and material.refused is None:
        refuse_live(live)
    moving = None
    if live and material.motion is not None:
        from hjsolve.reports.live.page import live_page

        moving = partial(live_page, motion=material.motion, asked=sliders)
    path = write_document(content, target, moving, sheet=sheet)
    if material.refused is not None:
        raise material.refused
    if content.unsettled:
        raise NotConvergedError(f"{content.unsettled}; everything else was written to {path}")
    return path


def outside_entry(subject: object) -> catalog.Entry | None:
    """Return the entry that is named, where it is not given by T and V: its reason is the report.

    Args:
        subject: what the report is asked of.
    """
    if not isinstance(subject, str | Path):
        return None
    entry = catalog.describe(subject)
    return entry if entry.refusal is not None else None


def write_document(
    content: Document, target: Path, completed: Callable[[str], str] | None = None, *,
    sheet: Sheet = PLAIN,
) -> Path:  # fmt: skip
    """Write a document in the format of its suffix.

    Args:
        content: the document.
        target: a path that ``checked_path`` has passed.
        completed: what becomes of the text; None for a page that stands still.
        sheet: its title, in place of the document's own, and its paper.

    Returns:
        The path.

    Raises:
        InvalidInputError: the file cannot be written, or no browser prints the PDF.
    """
    text = _WRITERS[target.suffix.lower()](replace(content, title=sheet.title or content.title))
    text = visible(text if completed is None else completed(text))
    if target.suffix.lower() in _PRINTED:
        text = sheet.on_paper(text, target)
    made = pdf.printed(text, target) if target.suffix.lower() == ".pdf" else text
    with readable_errors(target):
        files.replace(target, made)
    return target

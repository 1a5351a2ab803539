"""The page: fields on the left, what follows from them on the right. It knows NiceGUI; nothing else here does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from nicegui import background_tasks, events, ui

from hjsolve import catalog
from hjsolve.errors import HJSolveError
from hjsolve.explorer.first_question import question_about
from hjsolve.explorer.question import LONGEST, Drag, PageAnswer, PageQuestion, Portrait, Wanted
from hjsolve.explorer.worker import Workers
from hjsolve.reports.document.drawing_style import STYLE
from hjsolve.reports.formats.stylesheet import LIGHT, NOTEBOOK_CSS

_CSS = """
.nicegui-content{padding:0}
.explorer{display:grid;grid-template-columns:minmax(19rem,24rem) minmax(0,1fr);gap:1.5rem;width:100%;max-width:88rem;
margin:0 auto;padding:1.2rem;align-items:start}
@media (max-width:54rem){.explorer{grid-template-columns:minmax(0,1fr)}}
.explorer .fields{display:flex;flex-direction:column;gap:.35rem}
.explorer .portraits{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr));gap:1rem}
.explorer .start{display:grid;grid-template-columns:1fr 1fr;gap:.2rem .7rem;align-items:center}
.explorer .problem{color:var(--red);white-space:pre-wrap;overflow-wrap:anywhere}
.explorer .problem:empty{display:none}
.explorer .lead.yes{border-left:3px solid var(--green);padding-left:.8rem}
.explorer .lead.no{border-left:3px solid var(--red);padding-left:.8rem}
.explorer .lead.open{border-left:3px solid var(--amber);padding-left:.8rem}
.explorer .waiting{opacity:.45}
.explorer .unfinished,.explorer .stale{color:var(--soft);white-space:pre-wrap;overflow-wrap:anywhere}
.explorer .stale{border-left:3px solid var(--amber);padding-left:.8rem}
.explorer .unfinished:empty,.explorer .stale:empty{display:none}
.explorer section{min-width:0}.explorer .nicegui-expansion-content>*{width:100%;min-width:0}
.explorer .drag,.explorer .portraits svg{max-width:32rem}.explorer .portraits text{font-size:12.5px}
@media (max-width:40rem){.explorer{padding:.8rem}.explorer .formula{flex-wrap:wrap;gap:.1rem}
.explorer .formula .scroll{flex-basis:100%}.explorer .q-btn{min-height:2.75rem}
.explorer{--page:#fff}.body--dark .explorer{--page:#121212}
.explorer .scroll{overflow-x:auto;background:
linear-gradient(to left,var(--page) 40%,transparent) right/2.2rem 100% no-repeat local,
linear-gradient(to left,rgba(128,128,128,.6),transparent) right/.8rem 100% no-repeat scroll}}
.explorer .hint{color:var(--soft);font-size:.85rem}
.explorer .drag svg{cursor:crosshair;touch-action:none}
.explorer h1{font-size:1.3rem;line-height:1.3;font-weight:600;margin:0}
"""
_PRINTED = (
    "@media print{body.body--dark{background:#fff!important;color:#22262b!important}"
    ".q-layout,.q-page-container,.q-page{min-height:0!important}"
    f".body--dark .explorer,.body--dark .hjsolve{{{LIGHT};--page:#fff}}"
    ".body--dark .explorer :is(.q-field *,.q-item,.q-checkbox){color:#22262b!important}"
    ".explorer .q-btn,.explorer .q-item__section--side,.explorer .q-expansion-item--collapsed{display:none}"
    ".nicegui-error-popup,.q-loading-bar,.q-notify{display:none!important}.explorer{padding:0}"
    ".explorer .portraits>*,.explorer table{break-inside:avoid}}"
)
_POINTER = ["pointerdown", "pointermove"]


class Desk:
    """Asks the newest question of one page, one at a time: what was typed meanwhile takes the place of what waits."""

    def __init__(self, workers: Workers, shown: Callable[[PageQuestion, PageAnswer], None]):
        self.workers, self.shown = workers, shown
        self._waiting: PageQuestion | None = None
        self._busy = False

    def put(self, question: PageQuestion) -> None:
        """Ask as soon as what is being computed is done."""
        self._waiting = question
        if not self._busy:
            self._busy = True
            background_tasks.create(self._work())

    async def _work(self) -> None:
        try:
            while self._waiting is not None:
                question, self._waiting = self._waiting, None
                self.shown(question, await self.workers.ask(question))
        finally:
            self._busy = False


class ExplorerPage:
    """What one visitor sees."""

    def __init__(self, workers: Workers, question: PageQuestion):
        self.question = question
        self.desk = Desk(workers, self._show)
        self.workers = workers
        self._writing = False
        self._names: tuple[str, ...] = tuple(question.q)
        self._portraits: dict[str, tuple[Portrait, ui.interactive_image]] = {}
        ui.add_css(NOTEBOOK_CSS + STYLE + _CSS + _PRINTED)
        self.client = ui.context.client
        with ui.element("main").classes("explorer hjsolve"):
            with ui.element("section").classes("fields").props('aria-label="The system"'):
                self._build_fields()
            with ui.element("section").props('aria-label="What follows" aria-live="polite"'):
                self._build_answers()
        self._write(question)
        self._begun = False
        self.client.on_connect(self._begin)

    async def _begin(self) -> None:
        """Ask what the link asks once the socket is there; a page that nobody looks at computes nothing."""
        if self._begun:
            return
        self._begun = True
        with self.client:
            fragment = await self._fragment()
            if fragment.strip("#"):
                try:
                    self.question = PageQuestion.from_fragment(fragment)
                    self._write(self.question)
                except HJSolveError as error:
                    self.linked.set_text(" ".join(str(error).split()))
            self.desk.put(self.question)

    async def _fragment(self) -> str:
        """Return what stands after the # of the address."""
        return str(await ui.run_javascript("return location.hash", timeout=10.0) or "")

    # --------------------------------------------------------------------------------------- fields
    def _build_fields(self) -> None:
        ui.html("<h1>hjsolve: explore a system</h1>", sanitize=False)
        entries = ui.select(catalog.titles(), label="From the catalog", with_input=True, on_change=self._chosen)
        entries.props("dense clearable").mark("catalog")
        self.coordinates = self._area("Coordinates, one per line: x: line, r: 0 < r, theta: angle")
        self.kinetic = self._area("T, with dot(q) or q' for a velocity")
        self.potential = self._area("V")
        self.parameters = self._area("Parameters, one per line: k = 1 : positive")
        self.start = ui.element("div").classes("start")
        self.inputs: dict[tuple[str, str], ui.input] = {}
        self.find = ui.checkbox("Search for coordinates that separate", on_change=self._typed)
        with ui.row():
            ui.button("Check the system", on_click=self._submitted).props("outline no-caps")
            ui.button("Copy link", on_click=self._fraction).props("outline no-caps")
        self.linked = ui.label().classes("hint").props('role="status"').mark("linked")
        with ui.row():
            ui.button("Download report", on_click=lambda: self._download("report")).props("outline no-caps")
            ui.button("Download scene", on_click=lambda: self._download("scene")).props("outline no-caps")

    def _area(self, label: str) -> ui.textarea:
        area = ui.textarea(label, on_change=self._typed)
        area.props(f'dense autogrow maxlength={LONGEST} spellcheck=false input-class="font-mono"')
        return area

    def _field(self, label: str) -> ui.input:
        field = ui.input(label, on_change=self._typed)
        field.props(f'dense maxlength={LONGEST} spellcheck=false input-class="font-mono"')
        return field

    def _build_start(self, names: tuple[str, ...]) -> None:
        kept = {key: str(field.value or "") for key, field in self.inputs.items()}
        self.start.clear()
        self.inputs = {}
        with self.start:
            for name in names:
                for group, label in (("q", name), ("velocity", f"dot({name})")):
                    field = self._field(label)
                    field.set_value(kept.get((group, name), ""))
                    self.inputs[group, name] = field
        self._names = names

    def _write(self, question: PageQuestion) -> None:
        """Put a question into the fields, without asking it again."""
        self._writing = True
        self.coordinates.set_value(question.coordinates)
        self.kinetic.set_value(question.kinetic)
        self.potential.set_value(question.potential)
        self.parameters.set_value(question.parameters)
        self.find.set_value(question.find)
        if set(self.inputs) != {(group, name) for group in ("q", "velocity") for name in question.q}:
            self._build_start(tuple(question.q))
        self._write_start(question.q, question.velocity)
        self._writing = False

    def _write_start(self, q: object, velocity: object) -> None:
        for (group, name), field in self.inputs.items():
            values = q if group == "q" else velocity
            if isinstance(values, dict) and field.value != values.get(name, ""):
                field.set_value(values.get(name, ""))

    def _typed(self, _: events.EventArguments) -> None:
        if self._writing:
            return
        self.question = replace(self._read(), drag=None, submitted=False)
        self.desk.put(self.question)
        self.answers.classes(add="waiting")

    def _submitted(self) -> None:
        self.question = replace(self._read(), drag=None)
        self.desk.put(self.question)

    def _fraction(self) -> None:
        """Put the question into the address and on the clipboard."""
        fragment = self._read().fragment()
        ui.run_javascript(
            f"history.replaceState(null, '', location.pathname + '#{fragment}');"
            "navigator.clipboard && navigator.clipboard.writeText(location.href).catch(() => {})"
        )
        self.linked.set_text("The link is in the address bar, and copied where the browser allows it.")

    def _read(self) -> PageQuestion:
        return replace(
            self.question, coordinates=self.coordinates.value or "", kinetic=_one_line(self.kinetic),
            potential=_one_line(self.potential), parameters=self.parameters.value or "",
            find=bool(self.find.value), wanted="answer", submitted=True,
            q=self._typed_start("q"), velocity=self._typed_start("velocity"),
        )  # fmt: skip

    def _typed_start(self, group: str) -> dict[str, str]:
        return {name: str(self.inputs[group, name].value or "") for name in self._names}

    def _chosen(self, event: events.ValueChangeEventArguments[object]) -> None:
        if not event.value:
            return
        try:
            self.question = question_about(str(event.value))
        except HJSolveError as error:
            self.problem.set_text(" ".join(str(error).split()))
            return
        self._write(self.question)
        self.desk.put(self.question)

    # --------------------------------------------------------------------------------------- answers
    def _build_answers(self) -> None:
        self.problem = ui.label().classes("problem").props('role="alert"').mark("problem")
        self.unfinished = ui.label().classes("unfinished").props('role="status"').mark("unfinished")
        self.stale = ui.label().classes("stale").props('role="status"').mark("stale")
        self._answered: PageQuestion | None = None
        self.answers = ui.element("div")
        with self.answers:
            self.lead = ui.html("", sanitize=False).classes("lead").mark("lead")
            self.portraits = ui.element("div").classes("portraits")
            self.hint = ui.label("The large red point is the start: drag it.").classes("hint")
            self.drawings = ui.html("", sanitize=False)
            self.numbers = ui.html("", sanitize=False).mark("numbers")
            with ui.expansion("Why it separates, or does not", value=True).props("dense"):
                self.details = ui.html("", sanitize=False)
            with ui.expansion("W, time law and orbit equations").props("dense"):
                self.formulas = ui.html("", sanitize=False)

    def _show(self, question: PageQuestion, answer: PageAnswer) -> None:
        with self.client:
            self._show_here(question, answer)

    def _show_here(self, question: PageQuestion, answer: PageAnswer) -> None:
        self.problem.set_text(answer.problem)
        self.unfinished.set_text(answer.unfinished)
        if answer.coordinates and answer.coordinates != self._names:
            self._build_start(answer.coordinates)
        if not answer.verdict:
            self.answers.classes(add="waiting")
            self.stale.set_text(_out_of_date(self._answered))
            return
        self.answers.classes(remove="waiting")
        self._answered = question
        self.stale.set_text("")
        self.lead.set_content(answer.lead)
        self.lead.classes(replace=f"lead {answer.verdict}")
        self.details.set_content(answer.details)
        self.formulas.set_content(answer.formulas)
        self.numbers.set_content(answer.numbers)
        self.drawings.set_content(answer.drawings)
        self.hint.set_visibility(bool(answer.portraits) and not question.find)
        self._show_portraits(answer, draggable=not question.find)
        if question.drag is not None and answer.q:
            self._writing = True
            self._write_start(answer.q, answer.velocity)
            self._writing = False
            self.question = replace(question, q=answer.q, velocity=answer.velocity, drag=None)

    def _show_portraits(self, answer: PageAnswer, *, draggable: bool) -> None:
        if [p.name for p in answer.portraits] != list(self._portraits):
            self.portraits.clear()
            self._portraits = {}
            with self.portraits:
                for portrait in answer.portraits:
                    image = ui.interactive_image(
                        size=portrait.size, events=_POINTER, on_mouse=self._drag(portrait.name), sanitize=False
                    )
                    self._portraits[portrait.name] = portrait, image.classes("drag" if draggable else "")
        for portrait in answer.portraits:
            image = self._portraits[portrait.name][1]
            image.set_content(portrait.svg)
            self._portraits[portrait.name] = portrait, image

    def _drag(self, name: str) -> Callable[[events.MouseEventArguments], None]:
        def moved(event: events.MouseEventArguments) -> None:
            if not event.buttons & 1 or self.question.find:
                return
            portrait, _ = self._portraits[name]
            self.desk.put(replace(self._read(), drag=Drag(name, *portrait.at(event.image_x, event.image_y))))

        return moved

    # --------------------------------------------------------------------------------------- files
    async def _download(self, wanted: Wanted) -> None:
        answer = await self.workers.ask(replace(self._read(), wanted=wanted))
        if answer.file:
            ui.download.content(answer.file, "report.html" if wanted == "report" else "scene.toml")
        else:
            self.problem.set_text(answer.problem or "there is nothing to write yet")


def _out_of_date(answered: PageQuestion | None) -> str:
    """Return which system the verdict on the page belongs to, when it is not the one that is typed."""
    if answered is None:
        return ""
    return f"Out of date. What is shown below belongs to T = {answered.kinetic}, V = {answered.potential}."


def _one_line(area: ui.textarea) -> str:
    return " ".join((area.value or "").split())

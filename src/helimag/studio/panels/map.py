"""The map around the present point."""

from collections.abc import Callable
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from helimag.errors import InputError
from helimag.scenario import Scenario
from helimag.studio.elements import Map
from helimag.studio.jobs import Job
from helimag.studio.knobs import BY_PATH, DIRECTION, present, unit_text
from helimag.studio.mapping import (
    BOUNDARY_NODES,
    NODES,
    STEPS,
    WIDTHS,
    Axis2D,
    Cell,
    MapPlane,
    Stability,
    gain_cells,
    stability,
)
from helimag.studio.panels.controls import button
from helimag.studio.tab import Tab

WHAT = {"gain": "Gain of the run", "stability": "Stability of the orbit"}
AXES = ("drive.frequency", "drive.pitch")
EMPTY = {"label": "", "unit": "", "low": 0.0, "high": 1.0}
DESIGN_RUNS = 40
HINT = "Compute fills the map around the present point; Tolerances looks in it for the inputs that forgive most."


class MapPanel:
    """Two inputs to choose, the map, and what is computed for it."""

    def __init__(self, tab: Tab) -> None:
        self.tab = tab
        self.job = Job(tab.live)
        self.plane: MapPlane | None = None
        self.cells: list[Cell] = []
        self.curves: list[dict[str, object]] = []
        self.box: list[float] | None = None
        self.designed: Scenario | None = None
        self._build()
        tab.scenario_listeners.append(lambda _: self.show())

    def _build(self) -> None:
        paths = {knob.path: knob.label for knob in present(self.tab.scenario) if knob.path != DIRECTION}
        with ui.element("div").classes("hs-row"):
            self.what = ui.select(WHAT, value="gain", label="Map of")
            self.what.props('dense options-dense data-testid="map-what"')
            self.width = ui.select(list(WIDTHS), value="around", label="How far").props("dense options-dense")
        with ui.element("div").classes("hs-row"):
            self.axes = [ui.select(paths, value=path) for path in AXES]
            for axis, label in zip(self.axes, ("Across", "Up"), strict=True):
                axis.props(f'dense options-dense label="{label}" data-testid="map-{label.lower()}"')
        with ui.element("div").classes("hs-row"):
            button("Compute", "grid_view", self.start, "map-start", "solid")
            button("Tolerances", "crop_free", self.design, "map-design")
            self.stop_button = button("Stop", None, self.stop, "map-stop", "flat")
            self.go_button = button("Go to the design", None, self.go, "map-go", "flat")
        self.status = ui.label(HINT).classes("hs-small").props('data-testid="map-status"')
        self.map = Map().classes("hs-fill")
        self.map.show(
            first=EMPTY, second=EMPTY, cells=[], curves=[], point=[0.5, 0.5], box=None, what="gain", stale=False
        )
        self.map.on("pick", self.pick)
        ui.label(
            "Click to go there. Lighter is a larger gain; grey was lost: \u25b2 attracted, \u25bc fell, \u25a0 wall. "
            "Lines: where orbits lose stability (whole: fold, dashed: swing)."
        ).classes("hs-small")
        self.stop_button.set_visibility(False)
        self.go_button.set_visibility(False)
        self._frame()

    def _frame(self) -> bool:
        """Lay the axes about the present point; tells whether that can be."""
        try:
            axes = [
                Axis2D.around(BY_PATH[str(axis.value)], self.tab.scenario, str(self.width.value)) for axis in self.axes
            ]
            if axes[0].knob is axes[1].knob:
                raise InputError("a map needs two different inputs")
        except InputError as error:
            self.status.set_text(str(error))
            return False
        self.plane = MapPlane(self.tab.scenario, *axes)
        self.cells, self.curves, self.box, self.designed = [], [], None, None
        self.go_button.set_visibility(False)
        self.show()
        return True

    def show(self) -> None:
        """Draw what is known."""
        plane = self.plane
        if plane is None:
            return
        axes = [
            {"label": axis.knob.label, "unit": unit_text(axis.knob.unit), "low": axis.low, "high": axis.high}
            for axis in (plane.first, plane.second)
        ]
        here = [axis.knob.value(self.tab.scenario) for axis in (plane.first, plane.second)]
        self.map.show(
            first=axes[0],
            second=axes[1],
            cells=list(self.cells),
            curves=list(self.curves),
            point=[0.0 if value is None else value for value in here],
            box=self.box,
            what=str(self.what.value),
            stale=bool(self.cells) and not plane.holds_for(self.tab.scenario),
        )

    def start(self) -> None:
        """Compute the map anew about the present point."""
        if not self._frame() or self.plane is None:
            return
        plane, what = self.plane, str(self.what.value)
        add, replace = self.tab.in_page(self._add), self.tab.in_page(self._replace)

        def gains(progress: Callable[[float], None]) -> None:
            done: set[tuple[int, int]] = set()
            for step in STEPS:
                for cells in gain_cells(plane, step, done, progress):
                    progress(0.0)
                    add(cells)
                if step == STEPS[1]:
                    try:
                        replace(Stability([], stability(plane, BOUNDARY_NODES, progress).curves))
                    except InputError as error:
                        note(f"no boundary: {error}")

        def orbits(progress: Callable[[float], None]) -> None:
            for nodes in (BOUNDARY_NODES, 2 * BOUNDARY_NODES - 1):
                replace(stability(plane, nodes, progress))

        note = self.tab.in_page(self._say)
        if what == "gain":
            self._run("computing", gains, lambda _: self._say("complete"), counted=False)
        else:
            self._run("computing", orbits, lambda _: self._say("complete"))

    def design(self) -> None:
        """Find the inputs within the map that forgive most, with tolerances that full runs confirm."""
        if self.plane is None and not self._frame():
            return
        plane = self.plane
        if plane is None:
            return
        limits = {axis.knob.path: axis.ranged for axis in (plane.first, plane.second)}

        def work(progress: Callable[[float], None]) -> Any:
            from helimag.design import design

            return design(plane.scenario, limits=limits, runs=DESIGN_RUNS, progress=progress)

        def done(result: Any) -> None:
            knobs = plane.first.knob, plane.second.knob
            centre = [knob.value(result.scenario) or 0.0 for knob in knobs]
            self.box = [*centre, *(result.tolerances[knob.path] / knob.scale for knob in knobs)]
            self.designed = result.scenario
            self.go_button.set_visibility(True)
            offs = [
                f"{knob.label} {middle:.4g} \u00b1 {half:.2g} {unit_text(knob.unit)}"
                for knob, middle, half in zip(knobs, centre, self.box[2:], strict=True)
            ]
            self.status.set_text(f"{'; '.join(offs)}: {result.bounded} of {DESIGN_RUNS} runs with all inputs off stay")
            self.show()

        self._run("looking for inputs that forgive errors", work, done)

    def _run(
        self,
        words: str,
        work: Callable[[Callable[[float], None]], Any],
        done: Callable[[Any], None],
        *,
        counted: bool = True,
    ) -> None:
        """Do work beside the page; ``counted`` says how far it has come."""
        self.status.set_text(f"{words} ...")
        self.stop_button.set_visibility(True)

        def ended(result: Any) -> None:
            self.stop_button.set_visibility(False)
            done(result)

        def failed(problem: str) -> None:
            self.stop_button.set_visibility(False)
            self.status.set_text(problem)

        share = self.tab.in_page(lambda done: self.status.set_text(f"{words} ... {done:.0%}"))
        self.job.start(work, self.tab.in_page(ended), self.tab.in_page(failed), share if counted else None)

    def _say(self, words: str) -> None:
        self.status.set_text(words)

    def stop(self) -> None:
        """Give up what is being computed."""
        self.job.stop()
        self.stop_button.set_visibility(False)
        self.status.set_text("stopped")

    def go(self) -> None:
        """Take the designed inputs."""
        designed = self.designed
        if designed is not None:
            self.tab.change(lambda _: designed)

    def pick(self, event: GenericEventArguments) -> None:
        """Move the sliders to a place on the map."""
        plane = self.plane
        if plane is None or not isinstance(event.args, list) or len(event.args) != 2:
            return
        values = [float(value) for value in event.args]
        rounded = [
            round(value / axis.knob.step) * axis.knob.step
            for value, axis in zip(values, (plane.first, plane.second), strict=True)
        ]
        self.tab.change(
            lambda scenario: MapPlane(scenario, plane.first, plane.second).at(*(round(v, 9) for v in rounded))
        )

    def _add(self, cells: list[Cell]) -> None:
        self.cells += cells
        self.status.set_text(f"computing ... {len(self.cells)} of {NODES**2} cells")
        self.show()

    def _replace(self, found: Stability) -> None:
        self.cells = found.cells or self.cells
        self.curves = found.curves
        self.show()

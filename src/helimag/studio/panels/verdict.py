"""The verdict: how the run is judged, why, the gain, and what comes after the run."""

from nicegui import ui

from helimag.outcomes import Verdict
from helimag.studio.answer import Answer, Stage
from helimag.studio.live import News
from helimag.studio.tab import Tab

COMING = "what comes after it is being looked for"
# a shape for each, so that colour is not needed to tell them apart
SIGNS = {
    Verdict.BOUNDED: ("check_circle", "bounded"),
    Verdict.DRIFTING: ("trending_flat", "drifting"),
    Verdict.ATTRACTED: ("arrow_upward", "attracted"),
    Verdict.FELL: ("arrow_downward", "fell"),
    Verdict.WALL_LIMITED: ("crop_square", "wall"),
    Verdict.UNDECIDED: ("help_outline", "undecided"),
    Verdict.FAILED: ("error_outline", "failed"),
}
LABELS = {
    "gain": "Gain y / u",
    "output_y_m": "Range of heights y (m)",
    "input_u_m": "Height of the magnet above the start u (m)",
    "end_time_s": "Run ends at (s)",
    "escape_time_s": "Device lost at (s)",
    "slips": "Turns slipped against the field",
    "wobble_deg": "Wobble (deg)",
    "attack_angle_deg": "Attack angle, second half (deg)",
}


def verdict(tab: Tab) -> None:
    """Build the card of the verdict."""
    with ui.element("section").classes("hs-verdict hs-panel").props('data-testid="verdict" aria-live="polite"') as card:
        sign = ui.icon("hourglass_empty").classes("hs-sign")
        with ui.element("div").classes("hs-words"):
            with ui.element("div").classes("hs-headline"):
                word = ui.label("").classes("hs-word").props('data-testid="word"')
                stage = ui.label("").classes("hs-stage-note").props('data-testid="stage"')
            reason = ui.label("").classes("hs-reason").props('data-testid="reason"')
            outlook = ui.label("").classes("hs-outlook").props('data-testid="outlook"')
            told = ui.tooltip("").classes("hs-told")
        with ui.element("div").classes("hs-gain"):
            ui.label("gain y / u").classes("hs-small")
            gain = ui.label("").classes("hs-figure").props('data-testid="gain"')
            span = ui.label("").classes("hs-small")
        with ui.button(icon="more_horiz").props('flat round dense aria-label="All numbers" data-testid="numbers"'):
            table = _numbers()

    def show(answer: Answer) -> None:
        icon, kind = SIGNS[answer.verdict]
        sign.set_name(icon)
        sign.classes(replace=f"hs-sign hs-{kind}")
        word.set_text(str(answer.verdict))
        reason.set_text(answer.reason)
        gain.set_text(f"{answer.gain:.3f}")
        y, u = (1e3 * float(answer.numbers[name]) for name in ("output_y_m", "input_u_m"))
        span.set_text(f"{y:.1f} mm of {u:.1f} mm")
        for name, label in table.items():
            label.set_text(answer.numbers[name])

    def heard(news: News) -> None:
        card.props(f'data-number="{news.number}" data-stage="{news.stage.name}" data-problem="{bool(news.problem)}"')
        if news.answer is not None:
            show(news.answer)
            stage.set_text(_stage(news))
            outlook.set_text(f"For all time: {news.answer.outlook}" if news.answer.outlook else " ")
            told.set_text(f"{news.answer.reason}. {outlook.text}")
        if news.problem is not None:
            icon, kind = SIGNS[Verdict.FAILED]
            sign.set_name(icon)
            sign.classes(replace=f"hs-sign hs-{kind}")
            word.set_text("no run")
            reason.set_text(news.problem[:400])
            gain.set_text("-")
            stage.set_text("")
            outlook.set_text(" ")

    tab.news_listeners.append(heard)


def _stage(news: News) -> str:
    if news.stage is Stage.FIRST and news.run is not None:
        leapt = news.run.dataset.attrs.get("share_of_turns_leapt_over")
        end = float(news.run.dataset["time"].values[-1])
        return COMING if leapt else f"so far, first {end:.0f} s"
    return COMING if news.stage is Stage.WHOLE else ""


def _numbers() -> dict[str, ui.label]:
    """A menu with every number in full, as the command line prints it."""
    with ui.menu().classes("hs-numbers"):
        ui.label("Numbers in full").classes("hs-title")
        found = {}
        for name, label in LABELS.items():
            with ui.element("div").classes("hs-number-row"):
                ui.label(label)
                found[name] = ui.label("").classes("hs-mono").props(f'data-testid="full-{name}"')
    return found

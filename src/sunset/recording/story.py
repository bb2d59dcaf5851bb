"""What happened in a run, in words."""

from collections.abc import Iterable, Iterator, Sequence
from typing import IO, Any, Final, NoReturn

from rich.console import Console
from rich.table import Table
from rich.text import Text

from sunset.metrics import Episode, RunMetrics, Timeline
from sunset.recording.causes import Cause
from sunset.recording.logs import LogLine
from sunset.recording.schema import RunRecord
from sunset.system import current_system, find_fault
from sunset.texts import counted, printable, shorten

_STYLES = {
    "fault": "red",
    "healed": "green",
    "symptom": "yellow",
    "adaptation": "cyan",
    "cured": "green",
    "log": "blue",
    "end": "dim",
}

Event = tuple[float, str, str]
"""When it happened, in seconds from the injection on; of what kind it is, such as `symptom`; and in words."""

_REPEATING: Final = frozenset({"log", "adaptation"})

_UNBOUNDED: Final = 100_000
"""Columns of a line that is not wrapped."""


def print_story(
    run: RunRecord,
    events: Sequence[Event],
    causes: Sequence[Cause],
    metrics: RunMetrics,
    differing: Sequence[str],
    *,
    file: IO[str] | None = None,
) -> None:
    """Print the time line of a run and its metrics, on stdout or as plain text into a file; as of a `StoredRun`."""
    # no markup: names and values are the user's, brackets included
    console = _Console(
        file=file,
        force_terminal=None if file is None else False,
        force_jupyter=False,
        highlight=False,
        markup=False,
        emoji=False,
    )
    if not console.is_terminal:
        console.width = _UNBOUNDED  # what is searched or cut into fields stands in one line
    console.print()
    console.print(run.scenario, style="bold", soft_wrap=True)
    described = f"managing system {run.manager}, seed {run.seed}, model {run.model}"
    console.print(described, soft_wrap=True)
    console.print(f"faults: {', '.join(map(str, run.faults)) or 'none'}\n", soft_wrap=True)
    _print_events(console, _stated_once(events))
    if causes:
        _print_causes(console, causes)
    figures = Table(box=None, padding=(0, 1), show_header=False)
    for name, value, remark in figures_of(metrics):
        figures.add_row(name, Text(value, style="bold"), Text(remark, style="dim"))
    console.print_table(figures)
    if differing:
        console.print(
            f"\nStored otherwise than the messages give, and computed here: {', '.join(differing)}.",
            style="bold red",
        )
    if run.manager_failed is not None:
        console.print(f"\n{shorten(run.manager_failed)} The run went on without it.", style="bold red")
    if not run.valid:
        console.print(f"\nThis run does not count: {shorten(run.reason)}.", style="bold red")


def _print_events(console: "_Console", events: Sequence[Event]) -> None:
    """Print the time line."""
    table = Table(box=None, padding=(0, 1), show_header=False)
    table.add_column(justify="right")
    table.add_column()
    table.add_column()
    early = sum(time < 0 for time, _, _ in events)
    for number, (time, kind, text) in enumerate(events):
        if early and number in {0, early}:
            heading = "from the injection on" if number else "before the injection"
            table.add_row("", "", Text(heading, style="bold"))
        table.add_row(f"{time:6.2f} s", Text(kind, style=_STYLES[kind]), text)
    console.print_table(table)
    console.print()


def _print_causes(console: "_Console", causes: Sequence[Cause]) -> None:
    """Print what the time line does not say: which fault a symptom came from, and what cures it."""
    console.print(" the faults, which only the oracle is told", style="bold")
    table = Table(box=None, padding=(0, 1), show_header=False)
    for cause in causes:
        table.add_row(Text(cause.fault, style=_STYLES["fault"]), "showed as", cause.showed_as)
        if cause.looks_like:
            table.add_row("", "looks like", cause.looks_like)
        if cause.cured_by:
            table.add_row("", "cured by", cause.cured_by)
    console.print_table(table)
    console.print()


def _stated_once(events: Iterable[Event]) -> list[Event]:
    """Return events of which those that repeat are stated once, with how often they came and until when.

    Only what was logged or done repeats. Between two of its repetitions there are other such events at most: no fault,
    no symptom and no end of one.
    """
    stated: dict[tuple[object, ...], list[float]] = {}
    stretch = 0
    for time, kind, text in events:
        stretch += kind not in _REPEATING
        stated.setdefault((stretch, time < 0, kind, text), []).append(time)
    return [(times[0], str(kind), f"{text}{_repeated(times)}") for (*_, kind, text), times in stated.items()]


def _repeated(times: list[float]) -> str:
    more = len(times) - 1
    return f" … {more} time{'s' * (more > 1)} more until {times[-1]:.2f} s" if more else ""


class _Console(Console):
    """A console that shows every text as it is, and leaves a closed pipe to the entry point, as `print` does."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text of the user's or of a record's, made printable."""
        return super().render_str(printable(text), **options)

    def print_table(self, table: Table) -> None:
        """Print a table; where there is no terminal, without the spaces that fill its lines."""
        if self.is_terminal:
            self.print(table)
            return
        with self.capture() as captured:
            self.print(table)
        for line in captured.get().splitlines():
            self.print(line.rstrip(), soft_wrap=True)

    def on_broken_pipe(self) -> NoReturn:
        """Raise on; rich would exit with code 1."""
        raise  # noqa: PLE0704  rich calls this while it handles the BrokenPipeError


def events_of(timeline: Timeline, metrics: RunMetrics, log: Sequence[LogLine]) -> tuple[Event, ...]:
    """Return what happened in a run, in order of time."""
    return tuple(sorted(_events(timeline, metrics, log), key=lambda event: event[0]))


def _events(timeline: Timeline, metrics: RunMetrics, log: Sequence[LogLine]) -> Iterator[Event]:
    system = current_system()
    end_s = timeline.duration_s
    for injection in timeline.injections:
        if injection.time >= end_s:  # it counts for nothing
            continue
        known = find_fault(injection.fault)  # that of a record may be of another version
        yield injection.time, "fault", f"{injection.fault}: {known.description}" if known else injection.fault
        if injection.healed is not None and injection.healed < end_s:
            yield injection.healed, "healed", f"{injection.fault} has healed by itself"
        if injection.cured_away is not None and injection.cured_away < end_s:
            yield injection.cured_away, "cured", f"{injection.fault} was cured while it was away"
    for episode in metrics.failures:
        symptom = f"{episode.failure} {_cause(episode)}{system.failures[episode.failure].symptom}"
        # a time line of the experiment has no time before 0 for what began before
        since = ", since before the injection" if episode.holds == 0 else ""
        yield episode.holds, "symptom", symptom + since
        if episode.ended is not None:
            gone = f"{episode.failure} {system.failures[episode.failure].gone}{_resolution(episode)}"
            yield episode.ended, "cured", gone
    for adaptation in metrics.executed:
        yield adaptation.time, "adaptation", str(adaptation)
    loggers = {node.strip("/").replace("/", ".") for node in system.all_nodes}
    for line in log:
        if line.logger not in loggers:
            yield line.time, "log", str(line)
    yield end_s, "end", _ending(metrics)


def _cause(episode: Episode) -> str:
    if episode.injected:
        return ""
    return "(ripple) " if episode.failure in current_system().outages else "(not injected) "


def _resolution(episode: Episode) -> str:
    if episode.adaptation is None:
        return " (by itself)"
    return f", {episode.ended - episode.began:.2f} s after it began" if episode.ended is not None else ""


def _ending(score: RunMetrics) -> str:
    still = sorted({episode.failure for episode in score.failures if episode.ended is None})
    if not still:
        return "end of the experiment; no symptom is left"
    return "end of the experiment; still there: " + ", ".join(
        f"{failure} ({current_system().failures[failure].description})" for failure in still
    )


def figures_of(score: RunMetrics) -> Iterator[tuple[str, str, str]]:
    """Yield the figures that a time line ends with: what each is of, its value, and a remark."""

    def shown(value: float | None, unit: str = "") -> str:
        return "N/A" if value is None else f"{value:.2f}{unit}"

    episodes, adaptations = (
        counted(score.episodes, "failure episode"),
        counted(score.adaptations, "adaptation"),
    )
    resolved = f"{score.episodes_resolved} of {episodes}, {adaptations}"
    parts = f"detect {shown(score.t_detect_s)} + decide {shown(score.t_decide_s)}; repair {shown(score.t_repair_s)}"
    yield "resolved per adaptation", shown(score.f_resolved_per_adaptation), resolved
    yield "reaction time", shown(score.t_react_s, " s"), parts
    yield (
        "unnecessary redeploys",
        str(score.redeploys_unnecessary),
        "of nodes without a fault that only a redeploy cures",
    )
    yield "downtime", shown(score.t_down_s, " s"), f"availability {score.availability:.0%}"
    without = score.frames_without_truth
    unknown = f"; {counted(without, 'frame')} without labels left out" if without else ""
    yield "segmentation IoU", shown(score.iou), f"{shown(score.iou_all)} if a lost frame counts as 0{unknown}"
    masked_s = score.masked_s if score.outcomes else 0.0
    cured = f"{score.faults_cured or 0} of {len(score.outcomes)}"
    yield (
        "faults cured",
        cured,
        f"uncured for {shown(score.uncured_s, ' s')}; masked for {shown(masked_s, ' s')}",
    )
    price = f"{counted(score.needless, 'needless adaptation')}; all cost {score.cost_frames:g} frames"
    yield "utility", shown(score.utility), price
    if score.diagnoses:
        known = f"{score.faults_detected} detected, {score.faults_located} located"
        alarms = counted(score.false_alarms or 0, "false alarm")
        yield (
            "faults identified",
            f"{score.faults_identified} of {score.faults_injected}",
            f"{known}; {alarms}",
        )

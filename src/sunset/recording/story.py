"""The events, faults and figures of a run, in words; the faults are hidden from the managing system."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import IO, Any, Final, NoReturn

from rich.console import Console
from rich.table import Table
from rich.text import Text

from sunset.metrics import Episode, FaultOutcome, RunMetrics, Timeline
from sunset.recording.schema import RunRecord, StoredFault
from sunset.recording.timelines import LogLine
from sunset.system import Fault, current_system, find_fault
from sunset.texts.sentences import counted, listed
from sunset_ros.texts import printable, shorten

Event = tuple[float, str, str]
"""Seconds from the injection, the kind of event, such as `symptom`, and the event in words."""

_STYLES: Final = {
    "fault": "red",
    "healed": "green",
    "symptom": "yellow",
    "adaptation": "cyan",
    "cured": "green",
    "log": "blue",
    "end": "dim",
}
_REPEATING: Final = frozenset({"log", "adaptation"})
_MOST: Final = 4  # occurrences of a fault that are listed
_LATE_S: Final = 0.1
"""The delay at which a fault still counts as on time, and a symptom as gone with its fault."""
_UNBOUNDED: Final = 100_000  # columns of a line that is not wrapped


@dataclass(frozen=True, slots=True)
class Cause:
    """A fault of a run, in words.

    Attributes:
        fault: its name.
        showed_as: its failure, and the ripples of the failure.
        looks_like: the other faults with this failure; may be empty.
        cured_by: its cure, and when the fault was cured.
    """

    fault: str
    showed_as: str
    looks_like: str
    cured_by: str


def print_story(
    run: RunRecord,
    events: Sequence[Event],
    causes: Sequence[Cause],
    metrics: RunMetrics,
    differing: Sequence[str],
    *,
    file: IO[str] | None = None,
) -> None:
    """Print the time line of a run, its faults and its figures, on stdout or as plain text into a file."""
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
        console.width = _UNBOUNDED  # so that lines can be searched and split into fields
    console.print()
    console.print(run.scenario, style="bold", soft_wrap=True)
    console.print(f"managing system {run.manager}, seed {run.seed}, model {run.model}", soft_wrap=True)
    console.print(f"faults: {', '.join(map(str, run.faults)) or 'none'}\n", soft_wrap=True)
    _print_events(console, _stated_once(events))
    if causes:
        _print_causes(console, causes)
    table = _table()
    for name, value, remark in figures_of(metrics):
        table.add_row(name, Text(value, style="bold"), Text(remark, style="dim"))
    console.print_table(table)
    for remark in remarks_of(run, differing):
        console.print(f"\n{remark}", style="bold red")


def _table() -> Table:
    return Table(box=None, padding=(0, 1), show_header=False)


def _print_events(console: "_Console", events: Sequence[Event]) -> None:
    table = _table()
    table.add_column(justify="right")
    early = sum(time < 0 for time, _, _ in events)
    for number, (time, kind, text) in enumerate(events):
        if early and number in {0, early}:
            heading = "from the injection on" if number else "before the injection"
            table.add_row("", "", Text(heading, style="bold"))
        table.add_row(f"{time:6.2f} s", Text(kind, style=_STYLES[kind]), text)
    console.print_table(table)
    console.print()


def _print_causes(console: "_Console", causes: Sequence[Cause]) -> None:
    console.print(" the faults, which only the oracle is told", style="bold")
    table = _table()
    for cause in causes:
        table.add_row(Text(cause.fault, style=_STYLES["fault"]), "showed as", cause.showed_as)
        if cause.looks_like:
            table.add_row("", "looks like", cause.looks_like)
        if cause.cured_by:
            table.add_row("", "cured by", cause.cured_by)
    console.print_table(table)
    console.print()


def _stated_once(events: Iterable[Event]) -> list[Event]:
    """Return the events with repetitions of logs and adaptations combined, unless another event came between them."""
    stated: dict[tuple[int, bool, str, str], list[float]] = {}
    stretch = 0
    for time, kind, text in events:
        stretch += kind not in _REPEATING
        stated.setdefault((stretch, time < 0, kind, text), []).append(time)
    combined = []
    for (_, _, kind, text), times in stated.items():
        often = f" … {counted(len(times) - 1, 'time')} more until {times[-1]:.2f} s" if len(times) > 1 else ""
        combined.append((times[0], kind, f"{text}{often}"))
    return combined


class _Console(Console):
    """A console that escapes control characters, and raises if the pipe is closed, as `print` does."""

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a printable text."""
        return super().render_str(printable(text), **options)

    def print_table(self, table: Table) -> None:
        """Print a table; outside of a terminal, without spaces at the end of lines."""
        if self.is_terminal:
            self.print(table)
            return
        with self.capture() as captured:
            self.print(table)
        for line in captured.get().splitlines():
            self.print(line.rstrip(), soft_wrap=True)

    def on_broken_pipe(self) -> NoReturn:
        """Raise the error again; rich would exit with code 1."""
        raise  # noqa: PLE0704  rich calls this while it handles the BrokenPipeError


def events_of(timeline: Timeline, metrics: RunMetrics, log: Sequence[LogLine]) -> tuple[Event, ...]:
    """Return the events of a run, in order of time."""
    return tuple(sorted(_events(timeline, metrics, log), key=lambda event: event[0]))


def _events(timeline: Timeline, metrics: RunMetrics, log: Sequence[LogLine]) -> Iterator[Event]:
    system = current_system()
    end_s = timeline.duration_s
    for injection in timeline.injections:
        if injection.time >= end_s:  # no figure counts it
            continue
        fault = find_fault(injection.fault)  # None if the record is of another version
        yield injection.time, "fault", f"{injection.fault}: {fault.description}" if fault else injection.fault
        if injection.healed is not None and injection.healed < end_s:
            yield injection.healed, "healed", f"{injection.fault} has healed by itself"
        if injection.cured_away is not None and injection.cured_away < end_s:
            yield injection.cured_away, "cured", f"{injection.fault} was cured while it was away"
    for episode in metrics.failures:
        cause = "" if episode.injected else f"({cause_of(episode)}) "
        symptom = f"{episode.failure} {cause}{system.failures[episode.failure].symptom}"
        # episodes that began before the injection are cut at 0
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
    remaining = remaining_failures(metrics)
    state = f"still there: {', '.join(remaining)}" if remaining else "no symptom is left"
    yield end_s, "end", f"end of the experiment; {state}"


def cause_of(episode: Episode) -> str:
    """Return the cause of an episode: `injected`, `ripple` or `not injected`."""
    if episode.injected:
        return "injected"
    return "ripple" if episode.failure in current_system().outages else "not injected"


def _resolution(episode: Episode) -> str:
    if episode.adaptation is None:
        return " (by itself)"
    return f", {episode.ended - episode.began:.2f} s after it began" if episode.ended is not None else ""


def remaining_failures(metrics: RunMetrics) -> list[str]:
    """Return the failures that last to the end of a run, with their descriptions."""
    failures = current_system().failures
    names = sorted({episode.failure for episode in metrics.failures if episode.ended is None})
    return [f"{name} ({failures[name].description})" for name in names]


def remarks_of(run: RunRecord, differing: Sequence[str]) -> list[str]:
    """Return a sentence for each reason to distrust a run or its stored figures, of which some are `differing`."""
    remarks = []
    if differing:
        names = ", ".join(differing)
        remarks.append(f"Stored otherwise than the messages give, and computed here: {names}.")
    if run.manager_failed is not None:
        remarks.append(f"{shorten(run.manager_failed)} The run went on without it.")
    if not run.valid:
        remarks.append(f"This run does not count: {shorten(run.reason)}.")
    return remarks


def figures_of(score: RunMetrics) -> Iterator[tuple[str, str, str]]:
    """Yield the figures at the end of a time line: name, value, and a remark."""
    episodes = counted(score.episodes, "failure episode")
    resolved = f"{score.episodes_resolved} of {episodes}, {counted(score.adaptations, 'adaptation')}"
    before = f"detect {_number(score.t_detect_s)} + decide {_number(score.t_decide_s)}"
    of_nodes = "of nodes without a fault that only a redeploy cures"
    frames = counted(score.frames_without_truth, "frame")
    unknown = f"; {frames} without labels left out" if score.frames_without_truth else ""
    masked_s = score.masked_s if score.outcomes else 0.0
    faults = f"uncured for {_number(score.uncured_s, ' s')}; masked for {_number(masked_s, ' s')}"
    price = f"{counted(score.needless, 'needless adaptation')}; all cost {score.cost_frames:g} frames"
    yield "resolved per adaptation", _number(score.f_resolved_per_adaptation), resolved
    yield "reaction time", _number(score.t_react_s, " s"), f"{before}; repair {_number(score.t_repair_s)}"
    yield "unnecessary redeploys", str(score.redeploys_unnecessary), of_nodes
    yield "downtime", _number(score.t_down_s, " s"), f"availability {score.availability:.0%}"
    yield (
        "segmentation IoU",
        _number(score.iou),
        f"{_number(score.iou_all)} if a lost frame counts as 0{unknown}",
    )
    yield "faults cured", f"{score.faults_cured or 0} of {len(score.outcomes)}", faults
    yield "utility", _number(score.utility), price
    if score.diagnoses:
        alarms = counted(score.false_alarms or 0, "false alarm")
        known = f"{score.faults_detected} detected, {score.faults_located} located; {alarms}"
        yield "faults identified", f"{score.faults_identified} of {score.faults_injected}", known
    if score.think_s is not None:
        tokens = f"{score.tokens_in} tokens in, {score.tokens_out} out"
        asked = f"{tokens}, of {listed(score.models_asked)}; " if score.models_asked else ""
        yield (
            "costs of thinking",
            f"{score.price or 0:g}",
            f"{asked}adaptations delayed for {score.think_s:.2f} s",
        )


def _number(value: float | None, unit: str = "") -> str:
    return "N/A" if value is None else f"{value:.2f}{unit}"


def causes_of(
    timeline: Timeline, metrics: RunMetrics, planned: Sequence[StoredFault] = ()
) -> tuple[Cause, ...]:
    """Return the faults of a run in the order of their injection, each once, and then those that did not come.

    Faults of another version's catalogue are left out.
    """
    faults = current_system().faults
    healed = {(injection.fault, injection.healed) for injection in timeline.injections}
    came: dict[str, list[str]] = {}
    for outcome in metrics.outcomes:
        if (outcome.fault, outcome.until) in healed:
            text = _cure_text(outcome) or f"healed by itself at {outcome.until:.2f} s"
        else:
            text = _cure_text(outcome) + _healing_text(outcome, metrics, planned)
        came.setdefault(outcome.fault, []).append(text)
    causes = []
    for name, cures in came.items():
        if fault := find_fault(name):
            alike = [
                other.name
                for other in faults.values()
                if other.failure == fault.failure and other is not fault
            ]
            shown = _showed_as(fault.failure, metrics)
            causes.append(Cause(fault.name, shown, ", ".join(alike), _cured_by(fault, cures)))
    missing = [fault for fault in planned if fault.name not in came]
    return (*causes, *(Cause(fault.name, _did_not_come(fault, timeline), "", "") for fault in missing))


def _did_not_come(fault: StoredFault, timeline: Timeline) -> str:
    if fault.after is None:
        return "nothing: it did not come in the time of the run"
    leader, delay_s = str(fault.after["fault"]), float(fault.after["delay"])
    times = [injection.time for injection in timeline.injections if injection.fault == leader]
    if not times or times[0] >= timeline.duration_s:
        return f"nothing: it did not come, since {leader} did not"
    due_s = times[0] + delay_s
    reason = "the run had ended" if due_s >= timeline.duration_s else f"{leader} was gone"
    return f"nothing: it did not come, since {reason} by {due_s:.2f} s"


def _showed_as(failure: str, metrics: RunMetrics) -> str:
    system = current_system()
    text = f"{failure} ({system.failures[failure].description})"
    if not any(episode.injected and episode.failure == failure for episode in metrics.failures):
        return f"nothing; it can show as {text}"
    ripples = {
        episode.failure
        for episode in metrics.failures
        if not episode.injected
        and {failure, episode.failure} <= system.outages
        and system.failing_nodes[failure] in system.upstream[system.failing_nodes[episode.failure]]
    }
    return f"{text}; {listed(sorted(ripples))} by ripple, for lack of input" if ripples else text


def _cure_text(outcome: FaultOutcome) -> str:
    """Return when a fault was cured; empty if it was not."""
    if outcome.cured is None:
        return ""
    in_place = outcome.cured == outcome.began > 0
    away = " (while it was away)" if outcome.cured > outcome.until else ""
    return f"{'in place' if in_place else 'done'} at {outcome.cured:.2f} s{away}"


def _healing_text(outcome: FaultOutcome, metrics: RunMetrics, planned: Sequence[StoredFault]) -> str:
    """Return when a fault that was cured would have healed, and how long its symptom outlasted that."""
    healing_s = next(
        (
            fault.until
            for fault in planned
            if fault.name == outcome.fault
            and fault.until is not None
            and fault.at <= outcome.began + _LATE_S < fault.until
        ),
        None,
    )
    if outcome.cured is None or healing_s is None:
        return ""
    ends = [
        episode.ended
        for episode in metrics.failures
        if episode.failure == outcome.failure
        and episode.injected
        and outcome.began <= episode.began < healing_s
    ]
    late_s = max((end - healing_s for end in ends if end is not None), default=0.0)
    later = f", {late_s:.2f} s before {outcome.failure} was over" if late_s > _LATE_S else ""
    return f" (it would have healed by itself at {healing_s:.2f} s{later})"


def _cured_by(fault: Fault, texts: Sequence[str]) -> str:
    cures = [text or "not done" for text in texts if text or fault.cures]
    more = f" … {len(cures) - _MOST} times more" if len(cures) > _MOST else ""
    times = listed(cures[:_MOST]) + more if cures else ""
    return "; ".join(filter(None, (fault.cured_by, times)))

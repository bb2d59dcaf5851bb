"""The page of a leaderboard: the tables of a report, of the managing systems of many bundles."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final
from urllib.parse import quote

from msgspec import json, structs

from sunset.evaluation.figure_frame import SHIPPED
from sunset.evaluation.formats import Block, Cell, Column, Link, Quantity, Report, as_html
from sunset.evaluation.intervals import INTERVALS
from sunset.evaluation.layout import FAULT_COLUMNS, lead_blocks, lead_notes
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import ScoreTable, score_table
from sunset.evaluation.summary import estimate_figure, manager_names
from sunset.recording import CampaignPlan
from sunset.texts.sentences import counted

_COLUMNS: Final = (
    FAULT_COLUMNS["cost_frames"],
    Column("date", "of publication, by the authors"),
    Column("authors", "as the bundle names them"),
    Column("bundle", "the campaign, with the source of its managing systems"),
    Column("run again", "runs of the bundle that the maintainer ran again, of all; and all that was checked"),
)

BUNDLES: Final = "bundles"
"""The folder beside the page with each bundle, and the result of its verification."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """A bundle that was verified.

    Attributes:
        name: of the bundle on the page, unique there.
        runs: of the campaign's suite, at least one.
        date: of publication, such as 2026-03-14.
        again: the number of runs that were run again.
    """

    name: str
    plan: CampaignPlan
    runs: Sequence[RunRow]
    date: str
    authors: str
    again: int

    @property
    def group(self) -> bytes:
        """The key of comparable campaigns: the scenarios, and the plan without its managing systems."""
        scenarios = {(run.suite, run.scenario, run.faults, run.flight.bag) for run in self.runs}
        others = (
            "suite",
            "scenarios_checksum",
            "bag",
            "managers",
            "manager_checksums",
            "runs",
            "references",
            "score",
        )
        plan = structs.asdict(self.plan) | dict.fromkeys(others) | {"versions": self.runs[0].version}
        return json.encode((sorted(scenarios), plan), order="deterministic")


Entries = Mapping[str, tuple[Submission, Sequence[RunRow]]]
"""The name of a row → its bundle, and its runs."""


def leaderboard_page(submissions: Sequence[Submission], notes: Sequence[str]) -> str:
    """Return the page of a leaderboard, with tables for each group of comparable campaigns; `notes` come first."""
    groups: dict[bytes, list[Submission]] = {}
    for submission in submissions:
        groups.setdefault(submission.group, []).append(submission)
    blocks: list[Block] = []
    tables, facts = [], []
    for group in groups.values():
        entries = _entries(group)
        table = score_table(_title(group[0]), {name: runs for name, (_, runs) in entries.items()})
        blocks += _blocks(table, entries)
        tables.append(table)
        facts.append(_facts(table.title, group[0]))
    lines = [*notes, *facts, *lead_notes(tables), *([INTERVALS] if tables else [])]
    return as_html(Report(blocks, lines), title="SUNSET: leaderboard")


def _entries(group: Sequence[Submission]) -> Entries:
    """Return the rows of comparable campaigns; SUNSET's own managing systems are rows of the first that has them."""
    entries: dict[str, tuple[Submission, Sequence[RunRow]]] = {}
    for submission in group:
        names = manager_names({run.manager for run in submission.runs})
        for manager, name in sorted(names.items()):
            if name not in entries or manager not in SHIPPED:
                row = f"{name} of {submission.name}" if name in entries else name
                entries[row] = submission, [run for run in submission.runs if run.manager == manager]
    return entries


def _blocks(table: ScoreTable, entries: Entries) -> Iterator[Block]:
    """Yield the tables of a report; the first also has the costs and the bundle of each row."""
    scores, *others = lead_blocks([table])
    lines = [line._replace(cells=(*line.cells, *_cells(*entries[line.label]))) for line in scores.lines]
    yield scores._replace(columns=(*scores.columns, *_COLUMNS), lines=lines)
    yield from (block for block in others if block.lines)


def _cells(submission: Submission, runs: Sequence[RunRow]) -> tuple[Cell, ...]:
    cost = estimate_figure([run for run in runs if run.valid], "cost_frames")
    address = f"{BUNDLES}/{quote(submission.name)}"
    return (
        Quantity(cost.mean) if cost else None,
        submission.date,
        submission.authors,
        Link(submission.name, f"{address}.zip"),
        Link(f"{submission.again}/{submission.plan.runs}", f"{address}.txt"),
    )


def _title(example: Submission) -> str:
    plan = example.plan
    seeds = f"{counted(plan.repetitions, 'seed')} from {plan.seed}"
    return f"{example.runs[0].suite or plan.suite}, {seeds}, SUNSET {example.runs[0].version}"


def _facts(title: str, example: Submission) -> str:
    """Return the common settings of all campaigns of a group in a sentence."""
    plan, run = example.plan, example.runs[0]
    flights = dict.fromkeys(f"{run.flight.name or 'own'} ({run.flight.short_bag})" for run in example.runs)
    scenarios = counted(len({run.scenario for run in example.runs}), "scenario")
    split = f"; split: SHA-256 {plan.split}" if plan.split else ""
    return (
        f"{title}: {scenarios} of {run.flight.duration_s:g} s; flight {', '.join(flights)}; model {plan.model} (card: "
        f"SHA-256 {plan.model_checksum}); middleware {plan.middleware}{split}."
    )

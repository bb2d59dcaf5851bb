"""The page of a leaderboard: managing systems of many bundles, in a table for each group of comparable campaigns."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import PurePath
from typing import Final
from urllib.parse import quote

from msgspec import json, structs

from sunset.errors import RecordError
from sunset.evaluation.figure_frame import SHIPPED
from sunset.evaluation.formats import Block, Cell, Column, Line, Link, Quantity, Report, as_html, plain
from sunset.evaluation.intervals import INTERVALS
from sunset.evaluation.layout import (
    FAULT_COLUMNS,
    FIRST_COLUMNS,
    diagnosis_cells,
    interval_cell,
    lead_notes,
    p_text,
    score_line,
)
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import ScoreRow, ScoreTable, score_table
from sunset.evaluation.summary import SystemRow, manager_names
from sunset.recording import CampaignPlan
from sunset.scenarios import SplitDescription
from sunset.system import REPAIR
from sunset.texts.sentences import counted, listed

_DATE: Final = Column("date", "of publication, by the authors")
_AGAIN: Final = Column("run again", "runs that the maintainer ran again, of all; they left the same messages")
_WON: Final = Column(
    "pairs won",
    "against the row above: the share of common scenarios, flights and seeds in which it has more utility, ties by "
    "half; p of the difference in utility, adjusted after Holm",
)
_KNOWS: Final = Column(
    "knows", "what it looked at, and is ranked by: nothing, symptoms, images, or the faults"
)
_IDENTIFIED: Final = Column("identified ↑", "of all faults: the fault itself was reported, and how soon")
_COLUMNS: Final = (
    *(_KNOWS, FIRST_COLUMNS[1], _WON, FIRST_COLUMNS[5], FIRST_COLUMNS[4], FAULT_COLUMNS["cost_frames"]),
    *(_IDENTIFIED, _AGAIN, _DATE, Column("bundle", "the campaign, with the source of its managing systems")),
)
_BUNDLE_COLUMNS: Final = (
    _DATE,
    Column("authors", "as the bundle names them"),
    _AGAIN,
    Column("checked", "everything that was checked, and what was not"),
    Column("SHA-256", "the first digits, of the bundle"),
    Column("made with", "the versions that results depend on"),
)
_DIGITS, _SHORT = 16, 8  # of a checksum

BUNDLES: Final = "bundles"
"""The folder beside the page with each bundle, and the result of its verification."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """A bundle that was verified.

    Attributes:
        name: of the bundle on the page, unique there.
        runs: of the campaign's suite.
        scenarios: SHA-256 of the scenarios that were run.
        split: the split of the campaign; None for another suite.
        is_drawn_again: whether the split was drawn again from its published salt.
        date: of publication, such as 2026-03-14.
        again: managing system → how many of its runs were run again.
        sha256: of the bundle.
    """

    name: str
    plan: CampaignPlan
    runs: Sequence[RunRow]
    scenarios: str
    split: SplitDescription | None
    is_drawn_again: bool
    date: str
    authors: str
    again: Mapping[str, int]
    sha256: str

    @property
    def group(self) -> bytes:
        """The key of comparable campaigns: all of the plan but the managing systems, and the scenarios."""
        names = ("managers", "manager_checksums", "references", "score", "runs", "bag", "scenarios")
        plan = structs.asdict(self.plan) | dict.fromkeys(names)
        plan |= {"suite": self.runs[0].suite, "scenarios_checksum": self.scenarios}
        return json.encode(plan | {"versions": self.plan.versions.get("sunset")}, order="deterministic")


@dataclass
class Group:
    """Campaigns with the same scenarios, seeds, flights, model and settings.

    Attributes:
        systems: the name of a row → its runs.
        owners: the name of a row → the bundle that it is from.
        notes: a sentence for each row that a later bundle has, too.
    """

    systems: dict[str, list[RunRow]] = field(default_factory=dict)
    owners: dict[str, Submission] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add(self, submission: Submission) -> None:
        """Add the managing systems of a bundle, but for those that have the source and the runs of an earlier row.

        Raises:
            RecordError: it has nothing new, or runs of SUNSET's own managing systems, among them the references of
                scores, differ from the same runs of an earlier bundle.
        """
        self._check_shipped(submission)
        rows = {_content(runs): name for name, runs in self.systems.items()}
        by_manager: dict[str, list[RunRow]] = {}
        for run in submission.runs:
            by_manager.setdefault(run.manager, []).append(run)
        known = {
            name: rows[content] for name, runs in by_manager.items() if (content := _content(runs)) in rows
        }
        if len(known) == len(by_manager):
            owners = dict.fromkeys(self.owners[row].name for row in known.values())
            raise RecordError(f"all of its runs are in {listed([*owners])} already.")
        names = manager_names(set(by_manager))
        for manager, runs in by_manager.items():
            name, longer = names[manager], f"{names[manager]} of {submission.name}"
            if manager not in known:
                name = longer if name in self.systems else name
                self.systems[name], self.owners[name] = runs, submission
            elif manager not in SHIPPED:
                same = f"{known[manager]} of {self.owners[known[manager]].name}"
                self.notes.append(f"{longer} has the source and the runs of {same}.")

    def _check_shipped(self, submission: Submission) -> None:
        known = {
            (run.manager, run.sources, run.experiment): (run.digest, self.owners[name].name)
            for name, runs in self.systems.items()
            for run in runs
            if run.manager in SHIPPED and run.middleware == "sim"
        }
        for run in submission.runs:
            digest, other = known.get((run.manager, run.sources, run.experiment), (run.digest, ""))
            if digest != run.digest:
                raise RecordError(
                    f"its run of {run.manager} in {run.scenario}, seed {run.seed}, has other messages than the same "
                    f"run in {other}: one was changed, or made with other packages; run its campaign again here."
                )

    @property
    def _example(self) -> Submission:
        return next(iter(self.owners.values()))

    @property
    def version(self) -> str:
        """The version of SUNSET."""
        return self._example.runs[0].version

    def table(self, suffix: str = "") -> ScoreTable:
        """Return the scores of all rows; the suffix ends the title."""
        one = self._example
        suite = f"{one.runs[0].suite or PurePath(one.plan.suite).name} {one.plan.split[:_SHORT]}".rstrip()
        return score_table(f"{suite}, {_seeds(one.plan)}{suffix}", self.systems)

    def blocks(self, table: ScoreTable) -> Iterator[Block]:
        """Yield the table of the group; managing systems that looked at images are ranked apart."""
        for evidence, names in table.classes.items():
            rows = [row for row in table.rows if row.system in names]
            if self._example.plan.task != REPAIR:
                rows.sort(key=lambda row: -self._summary(row).total("faults_identified"))
            above: list[ScoreRow | None] = [None, *rows]
            lines = [self._line(row, higher, table) for row, higher in zip(rows, above, strict=False)]
            by = f", by {evidence}" if len(table.classes) > 1 else ""
            yield Block(f"Suite {table.title}{by}", _COLUMNS, lines, "", about=self._about())

    def _summary(self, row: ScoreRow) -> SystemRow:
        return SystemRow(row.system, self.systems[row.system])

    def _line(self, row: ScoreRow, above: ScoreRow | None, table: ScoreTable) -> Line:
        summary, owner = self._summary(row), self.owners[row.system]
        label, runs, (evidence, score, _, _, needless, cured) = score_line(row)
        harm = f"harm {plain(interval_cell(row.harm))}"
        repairs, cost = owner.plan.task == REPAIR, summary.estimates["cost_frames"]
        cells = (
            evidence,
            (harm if row.is_calm else score) if repairs else None,
            _won(row, above, table) if repairs else None,
            cured,
            needless,
            Quantity(cost.mean) if cost else None,
            diagnosis_cells(summary)[2] if summary.total("diagnoses") else None,
            f"{owner.again.get(row.manager, 0)}/{row.runs}",
            owner.date,
            Link(owner.name, _address(owner, "zip")),
        )
        return Line(label, runs, cells)

    def _about(self) -> str:
        """Return the common settings of all campaigns of the group, with hashes."""
        one, run = self._example, self._example.runs[0]
        flights = dict.fromkeys(f"{run.flight.name or 'own'} ({run.flight.short_bag})" for run in one.runs)
        number = len({run.scenario for run in one.runs})
        texts = [
            f"{counted(number, 'scenario')} of {run.flight.duration_s:g} s, {_seeds(one.plan)}, task {run.task}",
            f"flight {', '.join(flights)}, model {run.model} ({one.plan.model_checksum[:_SHORT]})",
            f"middleware {run.middleware}, SUNSET {run.version}",
            f"scenarios: SHA-256 {one.scenarios}",
        ]
        if split := one.split:
            texts.append(f"split {split.split}: SHA-256 {split.sha256}")
            if split.salt_sha256:
                drawn = f"were {'' if one.is_drawn_again else 'not '}drawn from it again"
                texts.append(f"salt: SHA-256 {split.salt_sha256}; the scenarios {drawn}")
        return "\n".join(texts)


def _content(runs: Sequence[RunRow]) -> frozenset[object]:
    """Return the content by which rows are the same: source, experiment and messages of each run."""
    return frozenset((run.sources or run.manager, run.experiment, run.digest) for run in runs)


def _seeds(plan: CampaignPlan) -> str:
    last = plan.seed + plan.repetitions - 1
    return f"seed {last}" if plan.repetitions == 1 else f"seeds {plan.seed} to {last}"


def _won(row: ScoreRow, above: ScoreRow | None, table: ScoreTable) -> Cell:
    """Return the share of pairs that a row won against the row above, and its p."""
    for pair in table.differences:
        if above and {pair.first, pair.second} == {row.system, above.system} and pair.pairs_won is not None:
            won = pair.pairs_won if pair.first == row.system else 1 - pair.pairs_won
            p = p_text(pair)
            return f"{won:.2f}" + (f" (p {p})" if p else "")
    return None


def leaderboard_page(
    groups: Sequence[Group], submissions: Sequence[Submission], refused: Mapping[str, str]
) -> str:
    """Return the page of a leaderboard.

    Args:
        groups: with a row or more each.
        submissions: all bundles that have a row.
        refused: the name of a bundle → why it has no row, in a sentence.
    """
    versions = {group.version for group in groups}
    tables = [group.table(f", SUNSET {group.version}" if len(versions) > 1 else "") for group in groups]
    blocks = [block for group, table in zip(groups, tables, strict=True) for block in group.blocks(table)]
    has_intervals = any(row.score and row.score.interval for table in tables for row in table.rows)
    notes = [*lead_notes(tables, beside=""), *([INTERVALS] if has_intervals else [])]
    notes += [note for group in groups for note in group.notes]
    if submissions:
        blocks.append(
            Block("The bundles", _BUNDLE_COLUMNS, [*map(_bundle_line, submissions)], "", first="bundle")
        )
    return as_html(
        Report(blocks, [*dict.fromkeys(notes)]), "\n".join(_refused(refused)), title="SUNSET: leaderboard"
    )


def _address(one: Submission, kind: str) -> str:
    return f"{BUNDLES}/{quote(one.name)}.{kind}"


def _bundle_line(one: Submission) -> Line:
    versions = ", ".join(f"{name} {version}" for name, version in sorted(one.plan.versions.items()))
    again = f"{sum(one.again.values())}/{one.plan.runs}"
    links = Link("result", _address(one, "txt")), Link(one.sha256[:_DIGITS], _address(one, "zip"))
    return Line(one.name, str(one.plan.runs), (one.date, one.authors, again, *links, versions))


def _refused(refused: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of a list in HTML: bundles, and why each is refused."""
    if refused:
        items = (f"<li><b>{escape(name)}</b>: {escape(text)}</li>" for name, text in refused.items())
        yield from ("<h2>Refused</h2>", "<ul>", *items, "</ul>")

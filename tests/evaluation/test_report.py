import csv
import html.parser
import io
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import sunset
from sunset.cli import main
from sunset.errors import InvalidInputError
from sunset.evaluation.formats import escape_latex
from sunset.evaluation.report import FORMATS, format_report
from sunset.evaluation.results import FIGURES, Flight, RunRow
from sunset.evaluation.scores import score_tables
from sunset.evaluation.summary import SystemRow, summarise

UGLY = r"my_dir/50%_ü_{a}\b^c~d$&#<script>'\"`|--µ中:Mine"


def run(
    manager: str,
    suite: str,
    seed: int,
    *,
    scenario: str = "s/1",
    reason: str = "",
    flight: Flight = Flight(20.0),  # noqa: B008  it cannot be changed
    **metrics: float | None,
) -> RunRow:
    figures: dict[str, float | None] = dict.fromkeys(FIGURES)
    figures |= {
        "iou": 0.4 + seed / 100,
        "iou_all": 0.3,
        "t_down_s": 6.0,
        "episodes": 4,
        "episodes_unresolved": 1,
        "needless": 0,
        "cost_frames": 0,
        "uncured_s": None,
        "iou_healthy": 0.5,
    } | metrics
    figures["utility"] = metrics.get("utility", figures["iou_all"])
    return RunRow(
        folder=Path("run"),
        scenario=scenario,
        suite=suite,
        manager=manager,
        seed=seed,
        model="lite",
        setting="0f",
        flight=flight,
        middleware="sim",
        digest="",
        metrics=figures,
        outcomes=(),
        valid=not reason,
        reason=reason,
    )


def table(*more: RunRow) -> list[SystemRow]:
    runs = [run("none", "nofault", seed) for seed in (1, 2, 3)]
    runs += [run("none", "degraded", seed) for seed in (1, 2, 3)]
    runs += [run("none", "paper", seed, t_down_s=20.0) for seed in (1, 2, 3)]
    for seed, react in ((1, 1.0), (2, 2.0), (3, None)):
        runs.append(
            run(
                "baseline",
                "paper",
                seed,
                t_react_s=react,
                f_resolved_per_adaptation=1.0,
                redeploys_unnecessary=2,
            )
        )
    return summarise([*runs, *more])


def row_of(text: str, label: str) -> list[str]:
    """Return the cells of the line with this label, of a table in text."""
    (line,) = [line for line in text.splitlines() if re.match(rf"{re.escape(label)}  ", line)]
    return re.split(r"\s{2,}", line.strip())


def test_text_shows_runs_means_and_deviations() -> None:
    main = format_report(table())
    assert row_of(main, "none, no faults") == [
        "none, no faults",
        "3",
        "N/A",
        "N/A",
        "N/A",
        "N/A",
        "0.42 ± 0.01",
    ]
    assert row_of(main, "baseline") == [
        "baseline",
        "3",
        "1.00 ± 0.00",
        "1.50 ± 0.71",
        "2.00 ± 0.00",
        "6.00 ± 0.00",
        "0.42 ± 0.01",
    ]


def test_json_has_the_intervals_of_the_paper_s_figures() -> None:
    fourth = run(
        "baseline", "paper", 4, t_react_s=1.5, f_resolved_per_adaptation=1.0, redeploys_unnecessary=2
    )
    (row,) = (
        row for row in json.loads(format_report(table(fourth), "json"))["rows"] if row["system"] == "baseline"
    )
    # runs of one scenario: 1.50 ± 4.303 · 0.5 / √3 of three, 0.425 ± 3.182 · 0.0129 / √4 of four
    assert row["t_react_s"]["ci95"] == pytest.approx([0.26, 2.74], abs=0.005)
    assert row["iou"]["ci95"] == pytest.approx([0.40, 0.45], abs=0.005)


def test_text_fits_a_hundred_columns_and_long_names_have_their_own_line() -> None:
    name = "a_rather_long_file_name_of_a_managing_system.py:AndItsClass"
    text = format_report(table(run(name, "paper", 1, t_down_s=12.34), run(name, "paper", 2, t_down_s=1.0)))
    assert max(map(len, text.splitlines())) <= 100
    assert name in text.splitlines()


def test_columns_of_text_are_aligned() -> None:
    main = format_report(table())
    lines = [line for line in main.splitlines() if " ± " in line or "N/A" in line]
    starts = {match.start() for line in lines for match in re.finditer(r"(?<=\s\s)\S", line[20:])}
    assert len(starts) <= 6  # five figures, and the number of runs


@pytest.mark.parametrize("form", FORMATS)
def test_no_published_figure_stands_in_a_report(form: str) -> None:
    text = format_report(table(), form)
    assert not [figure for figure in ("0.89", "1.32", "2.02", "6.52", "4.67") if figure in text]
    if form in {"table", "json"}:
        assert "'sunset report DIR --paper' shows them by those of the published" in " ".join(text.split())


@pytest.mark.parametrize("form", ["table", "latex", "html"])
def test_what_was_run_is_said_in_one_line(form: str) -> None:
    runs = [
        replace(run("baseline", "paper", seed, flight=Flight(20.0, bag="3c" * 32)), version="0.1.0")
        for seed in (3, 1, 2)
    ]
    text = " ".join(format_report(summarise(runs), form).split())
    assert "SUNSET 0.1.0; model lite; middleware sim; seeds 1 to 3; 20 s measured; flight 3c3c3c3c." in text
    other = replace(run("baseline", "paper", 7, flight=Flight(4.0)), model="own", middleware="cyclonedds")
    text = " ".join(format_report(summarise([*runs, other]), form).split())
    assert (
        "SUNSET 0.1.0, unknown; models lite, own; middlewares cyclonedds, sim; seeds 1, 2, 3, 7; "
        "20 s measured, 4 s measured; flights 3c3c3c3c, unknown." in text
    )


def test_figures_of_fewer_than_three_seeds_have_no_interval_and_a_note_says_so() -> None:
    two = [run("mine", "artifact", seed, scenario=f"artifact/{seed}") for seed in (1, 2)]
    note = "Figures of fewer than 3 seeds have no confidence interval:"
    two += [replace(one, manager="other") for one in two]
    text = format_report(summarise(two), "table", score_tables(two))
    assert "[" not in text
    assert note in text
    three = [*two, *(replace(one, seed=3) for one in two[::2])]
    assert note not in format_report(summarise(three), "table", score_tables(three))


def test_unresolved_failures_are_reported() -> None:
    _, _, more = format_report(table(), every=True).partition("More about")
    assert row_of(more, "baseline")[2] == "3/12 (25%)"


def test_runs_that_lack_a_figure_are_told() -> None:
    timid = [
        run("timid", "paper", seed, f_resolved_per_adaptation=ratio) for seed, ratio in ((1, 1.0), (2, None))
    ]
    text = format_report(table(*timid, run("timid", "paper", 3, iou=None)))
    assert "baseline: t_react is of 2 of 3 runs; in the others nothing was resolved." in text
    assert "timid: f_res/a_exec is of 1 of 3 runs; in the others nothing was adapted." in text
    assert "timid: IoU is of 2 of 3 runs; in the others no frame with labels came." in text


def test_what_a_reader_must_know_of_a_flight_is_told_once(store: Callable[..., Path], tmp_path: Path) -> None:
    warning = "No threshold of the entropy tells healthy frames of this flight from all faulty ones."
    for place, manager in enumerate(("none", "none", "baseline")):
        store(str(place), manager=manager, bag_checksum="ab12" * 16, flight_warning=warning, seed=place)
    text = " ".join(sunset.report(tmp_path).split())
    assert text.count(f"Flight ab12ab12: {warning}") == text.count(warning) == 1


def test_a_managing_system_that_fails_for_one_reason_in_many_runs_is_told_of_once() -> None:
    reason = "The managing system m.py:M failed in {}, seed {}: it raised KeyError: " + "'k' " * 1000
    failed = [
        run("m.py:M", "paper", seed, scenario=scenario, reason=reason.format(scenario, seed))
        for seed in (1, 2, 3)
        for scenario in ("paper/a", "paper/b")
    ]
    text = " ".join(format_report(summarise(failed)).split())
    assert (
        "6 invalid runs are left out of all columns but the score: The managing system m.py:M failed" in text
    )
    assert text.count("KeyError") == 1
    assert "… (6 times)." in text
    assert text.count("'k'") < 100


def test_a_reason_is_stripped_of_a_scenario_that_another_one_shares_its_name_with(
    store: Callable[..., Path], tmp_path: Path
) -> None:
    for place, faults in enumerate(([], [{"name": "gpu_failure", "value": None}])):
        reason = "The managing system m.py:M failed in rain, seed 1: it raised KeyError"
        store(str(place), scenario="rain", manager="m.py:M", faults=faults, valid=False, reason=reason)
    text = " ".join(sunset.report(tmp_path).split())
    assert "The managing system m.py:M failed: it raised KeyError (2 times)." in text


def test_invalid_runs_are_told_with_their_reasons() -> None:
    cheats = [run("baseline", "paper", seed, reason="it read the truth") for seed in (7, 8)]
    text = " ".join(format_report(table(*cheats, run("none", "paper", 9, reason="it crashed"))).split())
    assert (
        "baseline: 2 invalid runs are left out of all columns but the score: it read the truth (2 times)."
        in text
    )
    assert "none: 1 invalid run is left out of all columns but the score: it crashed." in text
    assert "Every run is valid" not in text
    assert "Every run is valid." in format_report(table())


def test_a_single_run_has_no_interval() -> None:
    text = format_report(summarise([run("baseline", "paper", 1)]))
    assert row_of(text, "baseline")[-1] == "0.41"


def test_json_has_the_names_of_the_command_line() -> None:
    content = json.loads(format_report(table(), "json"))
    rows = {row["system"]: row for row in content["rows"]}
    assert list(rows) == ["none, no faults", "none, F4 and F5", "none", "baseline"]
    baseline = rows["baseline"]
    assert baseline["runs"] == 3
    assert baseline["t_react_s"]["mean"] == 1.5
    assert baseline["t_react_s"]["std"] == pytest.approx(0.5**0.5)
    assert baseline["t_react_s"]["runs"] == 2
    assert baseline["iou"]["ci95"] == pytest.approx([0.42 - 0.02484, 0.42 + 0.02484], abs=1e-4)
    assert baseline["unresolved_rate"] == 0.25
    assert rows["none"]["f_resolved_per_adaptation"] is None
    assert rows["none, no faults"]["t_down_s"] is None
    assert {*FIGURES, "system", "runs"} <= set(baseline)


def test_json_has_the_invalid_runs() -> None:
    content = json.loads(format_report(table(run("none", "paper", 9, reason="it crashed")), "json"))
    (none,) = [row for row in content["rows"] if row["system"] == "none"]
    assert none["runs_invalid"] == 1
    assert none["invalid"] == [{"scenario": "s/1", "seed": 9, "reason": "it crashed"}]


def test_csv_has_a_line_for_each_figure_that_there_is() -> None:
    lines = list(csv.DictReader(io.StringIO(format_report(table(), "csv"))))
    found = {(line["system"], line["figure"]): line for line in lines}
    assert len(found) == len(lines)
    assert ("none, no faults", "t_down_s") not in found
    assert float(found["none, no faults", "iou"]["mean"]) == pytest.approx(0.42)
    react = found["baseline", "t_react_s"]
    assert (react["source"], react["runs"], react["figure_runs"], react["mean"]) == ("runs", "3", "2", "1.5")
    assert found["baseline", "unresolved_rate"]["mean"] == "0.25"
    assert len(lines[0]) <= 60


def latex_rows(text: str) -> list[list[str]]:
    """Return the cells of every table line."""
    return [
        re.split(r"(?<!\\)&", line.removesuffix(r"\\"))
        for line in text.splitlines()
        if line.endswith(r"\\") and "multicolumn" not in line
    ]


def test_latex_is_a_document_with_balanced_groups_and_full_lines() -> None:
    text = format_report(table(run(UGLY, "paper", 1)), "latex")
    assert text.startswith(r"\documentclass{article}")
    assert text.endswith("\\end{document}\n")
    assert text.isascii()
    bare = re.sub(r"\\[{}]", "", text)
    assert bare.count("{") == bare.count("}")
    assert re.findall(r"\\begin{(\w+\*?)}", text)[1:] == ["table*", "tabular", "itemize"]
    assert re.findall(r"\\caption{(.*)}", text)[0] == "The paper's figures."
    assert text.count("\n\\item ") > 3
    widths = [{len(cells) for cells in latex_rows(part)} for part in text.split(r"\begin{tabular}")[1:]]
    assert widths == [{7}]


def test_latex_shows_the_same_figures() -> None:
    rows = [[cell.strip() for cell in cells] for cells in latex_rows(format_report(table(), "latex"))]
    assert [
        "baseline",
        "3",
        *[rf"${x}$" for x in (r"1.00 \pm 0.00", r"1.50 \pm 0.71", r"2.00 \pm 0.00")],
    ] == (next(cells for cells in rows if cells[0] == "baseline")[:5])


def test_latex_escapes_every_special_character() -> None:
    assert escape_latex("a_b&c%d#e$f{g}h~i^j\\k") == (
        r"a\_b\&c\%d\#e\$f\{g\}h\textasciitilde{}i\textasciicircum{}j\textbackslash{}k"
    )
    assert escape_latex("ü中") == "u?"


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="there is no pdflatex to compile with")
def test_latex_compiles(tmp_path: Path) -> None:
    broken = run(UGLY, "paper", 2, reason=UGLY)
    (tmp_path / "report.tex").write_text(format_report(table(run(UGLY, "paper", 1), broken), "latex"))
    done = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "report.tex"],  # noqa: S607  on the PATH
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:]
    assert (tmp_path / "report.pdf").stat().st_size > 10_000


class Page(html.parser.HTMLParser):
    """Collects the table cells of a page, and checks that elements are nested."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()
        self.rows: list[list[str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        assert not {"src", "href"} & {name for name, _ in attrs}
        if tag != "meta":
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in {"td", "th"}:
            self.rows[-1].append(data)


def test_html_is_one_well_formed_page_that_loads_nothing() -> None:
    page = Page()
    page.feed(format_report(table(run(UGLY, "paper", 1)), "html"))
    assert page.open == []
    assert "script" not in page.seen
    assert [
        "baseline",
        "3",
        "1.00 ± 0.00",
        "1.50 ± 0.71",
        "2.00 ± 0.00",
        "6.00 ± 0.00",
        "0.42 ± 0.01",
    ] in page.rows


def test_html_escapes_names() -> None:
    text = format_report(table(run("<script>alert(1)", "paper", 1)), "html")
    assert "<script>" not in text
    assert "&lt;script&gt;" in text


def test_another_format_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="one of table, latex, csv, json, html, got 'xlsx'"):
        format_report(table(), "xlsx")


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_prints_an_empty_table_and_invalid_runs_only(form: str) -> None:
    assert format_report([], form)
    if form != "csv":  # which has a line for each figure
        assert "baseline" in format_report(summarise([run("baseline", "paper", 1, reason="no")]), form)


@pytest.mark.parametrize("form", FORMATS)
def test_a_folder_of_runs_is_rendered_stored_or_recomputed(
    store: Callable[..., Path], tmp_path: Path, form: str
) -> None:
    store("runs/1", seed=1)
    store("runs/2", seed=2, iou=0.3)
    assert sunset.report(tmp_path, form) == sunset.report(tmp_path, form, recompute=True)


@pytest.mark.parametrize("form", FORMATS)
def test_what_recomputing_corrects_is_told_in_every_format(
    store: Callable[..., Path], edit: Callable[..., None], tmp_path: Path, form: str
) -> None:
    store("runs/1", seed=1)
    folder = store("runs/2", seed=2)
    honest = sunset.report(tmp_path, form, recompute=True)
    stored = json.loads((folder / "run.json").read_text())["metrics"]
    edit(folder, metrics=stored | {"t_down_s": 0.0})
    told = sunset.report(tmp_path, form, recompute=True)
    assert told != honest
    words = {"json": '"figures": [', "csv": "runs_differing"}.get(
        form, "figures were stored that the messages"
    )
    assert words in " ".join(told.split())


def test_the_report_of_one_run_computes_its_figures_and_names_stored_ones_that_differ(
    store: Callable[..., Path], edit: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = store("run", faults=[])
    metrics = json.loads((folder / "run.json").read_text())["metrics"]
    assert main(["report", str(folder)]) == 0
    assert "computed here" not in capsys.readouterr().out
    for figure, value in (("t_down_s", 0.0), ("iou", 7)):
        edit(folder, metrics=metrics | {figure: value})
        assert main(["report", str(folder)]) == 0
        printed = " ".join(capsys.readouterr().out.split())
        assert f"Stored otherwise than the messages give, and computed here: {figure}." in printed


@pytest.mark.parametrize("form", FORMATS)
def test_what_a_terminal_would_obey_is_shown_instead(
    store: Callable[..., Path], tmp_path: Path, form: str
) -> None:
    hostile = "\x1b[2J\x1b]0;owned\x07\u202e\x9b1A"
    store("1", manager=f"mine{hostile}.py:Mine", model=f"lite{hostile}")
    store("2", seed=2, valid=False, reason=f"it raised{hostile}", manager="baseline")
    told = sunset.report(tmp_path, form)
    assert not {character for character in told if not character.isprintable()} - {"\n"}


def test_a_name_of_any_length_is_shortened_at_once() -> None:
    # one step a character takes minutes here
    text = format_report(table(run("a" * 1_000_000 + "b", "paper", 1)))
    (name,) = {line for line in text.splitlines() if line.startswith("aaa")}
    assert "…" in name
    assert name.endswith("ab")
    assert len(name) <= 100


def test_scenarios_of_two_splits_in_one_row_are_told(store: Callable[..., Path], tmp_path: Path) -> None:
    drawn = {"suite": "test", "scenario": "test-0001"}
    store("runs/1", **drawn, faults=[{"name": "gpu_failure", "value": True}])
    told = "baseline (test): it has scenarios of one name that differ, as those of two splits do."
    assert told not in " ".join(sunset.report(tmp_path).split())
    store("runs/2", **drawn, faults=[{"name": "sync_issue", "value": True}], iou=0.4)
    assert told in " ".join(sunset.report(tmp_path).split())

"""The block with the figures of the paper's evaluation script."""

import html
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from sunset.evaluation import render_report
from sunset.evaluation.script_figures import ScriptFigures
from sunset.metrics import LogFigures, Pool

Store = Callable[..., Path]


FIGURES = LogFigures(
    executed=4,
    succeeded=3,
    reactions_s=Pool.of([1.0, 2.0, 3.0]),
    redeploys=2,
    redeploys_unnecessary=1,
    t_down_s=4.0,
    ious=Pool.of([0.2, 0.4]),
)


def block(text: str) -> list[str]:
    """Return the cells of the block's lines, below its head."""
    _, _, rest = text.partition("By the paper's evaluation script\n\n")
    lines = rest.partition("\n\n")[0].splitlines()[1:]
    return [cell for line in lines if "──" not in line for cell in re.split(r"\s{2,}", line.strip())]


def test_over_logs_are_ratios_redeploys_and_downtimes_and_over_all_values_are_reactions_and_ious() -> None:
    logs = [
        FIGURES,
        replace(
            FIGURES,
            executed=4,
            succeeded=1,
            reactions_s=Pool.of([6.0]),
            redeploys_unnecessary=0,
            t_down_s=0.0,
            ious=Pool.of([0.9]),
        ),
        replace(FIGURES, refused="no rule was triggered", redeploys_unnecessary=-1),
    ]
    found = {name: pair and pytest.approx(pair) for name, pair in ScriptFigures.of(logs).figures.items()}
    assert found == {
        "f_resolved_per_adaptation": (0.5, 0.25),
        "t_react_s": (3.0, 3.5**0.5),  # of 1, 2, 3 and 6
        "redeploys_unnecessary": (0.0, (2 / 3) ** 0.5),
        "t_down_s": (2.0, 2.0),
        "iou": (0.5, (0.26 / 3) ** 0.5),
    }


def test_logs_that_are_all_refused_have_redeploys_only() -> None:
    found = ScriptFigures.of([replace(FIGURES, refused="no rule was triggered", redeploys_unnecessary=-2)])
    assert {name for name, pair in found.figures.items() if pair} == {"redeploys_unnecessary"}
    assert not found.counts


def test_a_report_has_the_block_with_the_papers_figures(
    store: Store, edit: Callable[..., None], tmp_path: Path
) -> None:
    store("idle", manager="none", command_s=30.0)
    folder = store("run")  # silent from 1.9 to 6.0, and its camera redeployed at 3.5
    text = render_report(tmp_path, every=True)
    cells = block(text)
    ours = "baseline|1|1.00 ± 0.00|2.60 ± 0.00|1.00 ± 0.00|4.10 ± 0.00|0.50 ± 0.00"
    papers = "published|0.89 ± 0.16|1.44 ± 1.32|2.02 ± 1.04|6.52 ± 4.67|0.30 ± 0.09"
    assert cells == f"{ours}|{papers}".split("|")
    assert "none: the paper's evaluation script refuses 1 of 1 logs, but for their redeploys: " in " ".join(
        text.split()
    )
    rows = json.loads(render_report(tmp_path, "json"))["rows"]
    assert rows[0]["by_paper_script"]["t_down_s"] is None
    assert rows[1]["by_paper_script"] == {
        "logs": 1,
        "logs_refused": 0,
        "f_resolved_per_adaptation": {"mean": 1.0, "std": 0.0},
        "t_react_s": {"mean": 2.6, "std": 0.0},
        "redeploys_unnecessary": {"mean": 1, "std": 0.0},
        "t_down_s": {"mean": 4.1, "std": 0.0},
        "iou": {"mean": 0.5, "std": 0.0},
    }
    assert "By the paper's evaluation script" in html.unescape(render_report(tmp_path, "html"))
    assert r"\label{tab:sunset-script}" in render_report(tmp_path, "latex")

    stored = json.loads((folder / "run.json").read_text())["by_paper_script"]
    edit(folder, by_paper_script=stored | {"succeeded": 0})
    assert block(render_report(tmp_path))[2] == "0.00 ± 0.00"
    again = render_report(tmp_path, recompute=True)
    assert block(again) == cells
    assert "computed here: by_paper_script of" in " ".join(again.split())
    edit(folder, by_paper_script=...)
    text = render_report(tmp_path)
    assert "By the paper's evaluation script\n" not in text
    assert "not stored with all runs of baseline; --recompute computes them." in " ".join(text.split())
    assert block(render_report(tmp_path, recompute=True)) == cells


def test_runs_that_do_not_count_are_not_in_it(store: Store, tmp_path: Path) -> None:
    store("run", valid=False, reason="it read the truth")
    (row,) = json.loads(render_report(tmp_path, "json"))["rows"]
    assert row["by_paper_script"] is None
    assert "evaluation script" not in render_report(tmp_path)

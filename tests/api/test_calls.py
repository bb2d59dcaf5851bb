"""What the calls from Python return."""

import functools
import importlib.util
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sunset
from sunset.api.options import Manager
from sunset.cli import main
from sunset.errors import InvalidInputError, MissingExtraError, RecordError
from sunset.evaluation.differences import Difference, PairedComparison, difference
from sunset.evaluation.intervals import Cluster
from sunset.managing import ManagingSystem, Symptoms
from sunset.recording import read_messages

pytestmark = pytest.mark.usefixtures("flight")


class Focus(ManagingSystem):
    def __init__(self, *, wait: int = 0, **options: Any) -> None:
        super().__init__(**options)
        self.wait = wait

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.autofocus_needed:
            self.wait -= 1
            if self.wait < 0:
                self.set_parameter("camera", "perform_autofocus", True)


@pytest.mark.thorough
def test_a_class_a_function_and_a_file_of_one_manager_leave_the_same_messages(tmp_path: Path) -> None:
    file = tmp_path / "focus.py"
    file.write_text(
        "from sunset.managing import ManagingSystem\n"
        "class Focus(ManagingSystem):\n"
        "    def adapt(self, symptoms):\n"
        "        if symptoms.autofocus_needed:\n"
        "            self.set_parameter('camera', 'perform_autofocus', True)\n"
    )

    def made(**options: Any) -> Focus:
        return Focus(wait=0, **options)

    managers: list[Manager] = [Focus, functools.partial(Focus, wait=0), made, f"{file}:Focus"]

    runs = [sunset.run("autofocus_needed", manager, seed=4, duration=2) for manager in managers]
    late = sunset.run("autofocus_needed", functools.partial(Focus, wait=3), seed=4, duration=2)

    assert len({run.digest for run in runs}) == 1
    assert late.digest != runs[0].digest
    assert [str(adaptation) for adaptation in runs[0].adaptations] == ["set camera.perform_autofocus to true"]
    assert all(run.record.manager_checksum for run in runs)


@pytest.mark.thorough
def test_runs_in_threads_are_those_of_one_after_the_other() -> None:
    def digest(seed: int) -> str:
        return sunset.run("nofault", "none", seed=seed, duration=1).digest

    alone = [digest(seed) for seed in (1, 2)]

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(digest, [1, 2] * 2)) == alone * 2


def test_a_run_that_was_kept_is_opened_again(tmp_path: Path) -> None:
    run = sunset.run("gpu_failure", "none", duration=2, out=tmp_path / "run")

    again = sunset.load(tmp_path / "run")

    assert isinstance(again, sunset.Run)
    assert (again.record, again.metrics) == (run.record, run.metrics)
    assert read_messages(tmp_path / "run")
    with pytest.raises(RecordError, match="is not a complete record"):
        read_messages(tmp_path)


def test_a_campaign_of_classes_is_flown_by_several_processes_and_compared(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []

    results = sunset.bench(
        "nofault",
        {"focus": Focus, "idle": "none"},
        out=tmp_path / "results",
        repetitions=2,
        references=False,
        score=False,
        duration=1,
        jobs=2,
        progress=lambda done, total: calls.append((done, total)),
    )

    assert [(run.manager, run.seed, run.valid) for run in results.runs] == [
        ("focus", 1, True),
        ("focus", 2, True),
        ("idle", 1, True),
        ("idle", 2, True),
    ]
    assert (calls[0], calls[-1]) == ((0, 4), (4, 4))
    comparison = results.compare("focus", "idle")
    assert (comparison.pairs, comparison.left_out) == (2, 0)
    difference = comparison["iou"].difference
    assert difference is not None
    assert difference.mean == 0.0  # nothing was broken, so neither did anything
    assert "focus" in results.table()
    assert results.rows is results.rows
    with pytest.raises(InvalidInputError, match="There is no figure 0: choose among"):
        comparison[0]  # type: ignore[index]
    opened = sunset.load(tmp_path / "results")
    assert isinstance(opened, sunset.Results)
    assert list(opened.runs) == list(results.runs)


@pytest.mark.thorough
def test_labels_tell_managers_of_one_name_apart(tmp_path: Path) -> None:
    managers: dict[str, Manager] = {
        "first": functools.partial(Focus, wait=0),
        "later": functools.partial(Focus, wait=3),
        "made": lambda **options: Focus(wait=3, **options),
        "again": lambda **options: Focus(wait=0, **options),
    }

    (tmp_path / "suite").mkdir()
    (tmp_path / "suite" / "blurred.yaml").write_text("name: blurred\nfaults: [autofocus_needed]\n")
    results = sunset.bench(
        tmp_path / "suite",
        managers,
        out=tmp_path / "results",
        repetitions=1,
        references=False,
        score=False,
        duration=2,
        jobs=2,
    )

    digests = {run.manager: run.digest for run in results.runs}
    assert digests["first"] == digests["again"] != digests["later"] == digests["made"]


def bench_focus(out: Path, manager: Manager) -> sunset.Results:
    return sunset.bench(
        "nofault", manager, out=out, repetitions=1, references=False, score=False, duration=1, jobs=1
    )


def test_a_campaign_is_continued_by_the_same_arguments_only(tmp_path: Path) -> None:
    first = bench_focus(tmp_path, functools.partial(Focus, wait=1))
    assert list(bench_focus(tmp_path, functools.partial(Focus, wait=1)).runs) == list(first.runs)
    with pytest.raises(InvalidInputError, match="Focus has changed since the campaign"):
        bench_focus(tmp_path, functools.partial(Focus, wait=2))


def test_a_campaign_of_what_nothing_is_known_of_is_not_continued(tmp_path: Path) -> None:
    bench_focus(tmp_path, lambda **options: Focus(wait=1, **options))
    with pytest.raises(
        InvalidInputError, match=r"nothing says whether its managing system .*lambda.* is the same"
    ):
        bench_focus(tmp_path, lambda **options: Focus(wait=2, **options))


@pytest.mark.thorough
def test_numbers_of_other_libraries_are_numbers(tmp_path: Path) -> None:
    numbers: list[Any] = [1, np.float64(1), np.int64(1), np.float32(1), Decimal(1)]

    runs = [sunset.run("nofault", "none", seed=np.int64(2), duration=one) for one in numbers]  # type: ignore[arg-type]
    results = sunset.bench(
        "nofault",
        "none",
        out=tmp_path,
        references=False,
        score=False,
        repetitions=np.int64(1),  # type: ignore[arg-type]
        jobs=np.int64(1),  # type: ignore[arg-type]
        duration=1,
    )

    assert len({run.digest for run in runs}) == 1
    assert {type(run.record.duration_s) for run in runs} == {float}
    assert len(results.runs) == 1


def test_an_agreement_without_the_live_extra_runs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise MissingExtraError("The live middleware needs cyclonedds.")

    monkeypatch.setattr("sunset.api.running.live_middleware", missing)

    with pytest.raises(MissingExtraError, match="needs cyclonedds"):
        sunset.agree("nofault", "none", out=tmp_path / "out")

    assert not (tmp_path / "out").exists()


@pytest.mark.xdist_group("live")
@pytest.mark.thorough
def test_an_agreement_is_of_pairs_and_says_how_far_it_is(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []

    (agreement,) = sunset.agree(
        "nofault",
        ["none"],
        out=tmp_path,
        duration=2,
        jobs=1,
        progress=lambda done, total: calls.append((done, total)),
    )

    assert len(agreement.pairs) + len(agreement.left_out) == 1
    assert calls == [(0, 2), (1, 2), (1, 2), (2, 2)]


@pytest.mark.skipif(importlib.util.find_spec("pandas") is not None, reason="pandas is installed")
def test_without_pandas_a_data_frame_is_refused_in_one_sentence(tmp_path: Path) -> None:
    run = sunset.run("nofault", "none", duration=1, out=tmp_path / "run")

    for one in (run, sunset.Results(tmp_path, [])):
        with pytest.raises(MissingExtraError, match="'pip install pandas' installs it"):
            one.to_frame()


def test_with_pandas_a_runs_data_frame_has_its_samples() -> None:
    pytest.importorskip("pandas")
    run = sunset.run("nofault", "none", duration=1)

    frame = run.to_frame()

    assert list(frame.columns) == ["signal", "time_s", "value"]
    assert (frame.signal == "iou").sum() == len(run.timeline.frames.times)


def test_to_import_sunset_loads_nothing_else() -> None:
    program = "import sys, sunset; print([n for n in sys.modules if n.startswith('sunset.')], dir(sunset))"

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert done.stdout.startswith(
        "[] ['CampaignOptions', 'FlightPlan', 'ManagingSystem', 'Options', 'Results', 'Run'"
    )


def test_every_name_is_there() -> None:
    for name in dir(sunset):
        assert getattr(sunset, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        getattr(sunset, "rnu")  # noqa: B009  mypy knows that there is none


def test_a_run_is_printed_as_its_report_and_named_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run = sunset.run("gpu_failure", "baseline", seed=3, duration=4, out=tmp_path / "run")

    assert main(["report", str(tmp_path / "run")]) == 0

    printed = capsys.readouterr().out
    monkeypatch.setenv("FORCE_COLOR", "1")  # says that every output is a terminal
    assert printed.strip("\n") == str(run) == str(sunset.load(tmp_path / "run"))
    assert sunset.report(tmp_path / "run").strip("\n") == str(run)
    assert "gpu_failure: " in printed
    assert sunset.report(tmp_path / "run", "table") == sunset.report(tmp_path / "run", recompute=True)
    assert repr(run) == (f"<run of gpu_failure, managing system baseline, seed 3, IoU {run.metrics.iou:.2f}>")


def test_a_comparison_is_printed_as_a_table() -> None:
    rows = [(Cluster("a", "flight", seed), 0.5 + seed / 10, 0.5) for seed in (1, 2, 3)]
    iou = difference("iou", rows)
    downtime = Difference(figure="t_down_s", first=None, second=None, difference=None, one_sided=1)
    comparison = PairedComparison(
        first="focus", second="none", pairs=3, left_out=0, differences=(iou, downtime)
    )

    head, *lines = [re.split(r" {2,}", line) for line in str(comparison).splitlines()]

    assert head == ["figure", "focus", "none", "difference", "95 % interval", "pairs"]
    # 0.2 ± t · s/√n, with t = 4.303 of two degrees of freedom and s/√n = 0.0577
    assert lines == [
        ["iou", "0.70", "0.50", "0.20", "-0.05 to 0.45", "3"],
        ["t_down_s", "N/A", "N/A", "N/A", "N/A", "0"],
    ]

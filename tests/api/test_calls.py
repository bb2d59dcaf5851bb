"""What the calls from Python return."""

import functools
import importlib.util
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import sunset
from sunset.api import Manager
from sunset.errors import MissingExtraError, RecordError
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

    runs = [sunset.run("autofocus_needed", manager, seed=4, duration=3) for manager in managers]
    late = sunset.run("autofocus_needed", functools.partial(Focus, wait=3), seed=4, duration=3)

    assert len({run.digest for run in runs}) == 1
    assert late.digest != runs[0].digest
    assert [str(adaptation) for adaptation in runs[0].adaptations] == ["set camera.perform_autofocus to true"]
    assert all(run.record.manager_checksum for run in runs)


def test_runs_in_threads_are_those_of_one_after_the_other() -> None:
    def digest(seed: int) -> str:
        return sunset.run("nofault", "none", seed=seed, duration=1).digest

    alone = [digest(seed) for seed in range(4)]

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(digest, [*range(4)] * 3)) == alone * 3


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
    opened = sunset.load(tmp_path / "results")
    assert isinstance(opened, sunset.Results)
    assert list(opened.runs) == list(results.runs)


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

    assert done.stdout.startswith("[] ['FlightPlan', 'ManagingSystem', 'Results', 'Run'")


def test_every_name_is_there() -> None:
    for name in sunset.__all__:
        assert getattr(sunset, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        getattr(sunset, "rnu")  # noqa: B009  mypy knows that there is none

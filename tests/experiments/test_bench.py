"""Campaigns: what is planned, and that killing one costs nothing that was finished."""

import errno
import json
import os
import re
import shlex
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import pytest
from tests.experiments.campaigns import RUNS, bench_command, content_of

import sunset
from sunset import generate_split
from sunset.data import read_bag, write_bag
from sunset.errors import InvalidInputError, OutputError, RecordError
from sunset.evaluation.results import load_results
from sunset.experiments import BenchSpec, Settings, Timing, bench, in_turn, plan, run_folder
from sunset.experiments.bench import locked_campaign
from sunset.recording import read_run
from sunset.scenarios import Scenario
from sunset.system import extended_system

pytestmark = pytest.mark.usefixtures("flight")

SHORT = Settings(timing=Timing(duration_s=1.0, warm_up_s=0.5))


def test_the_papers_campaign() -> None:
    runs = plan(BenchSpec())

    assert len(runs) == 3 * (1 + 9 + 3 * 54)
    assert len({run_folder(Path("out"), one) for one in runs}) == len(runs)
    assert sorted({one.seed for one in runs}) == [1, 2, 3]


def test_a_reference_row_is_not_run_twice() -> None:
    runs = plan(BenchSpec(suite="degraded", managers=("none", "baseline"), score=False, repetitions=1))

    assert len(runs) == 1 + 9 + 9


def test_the_managing_systems_that_scores_are_measured_between_are_run_once() -> None:
    spec = BenchSpec(suite="degraded", managers=("baseline", "oracle"), references=False, repetitions=1)

    assert [one.manager for one in plan(spec)] == ["baseline"] * 9 + ["oracle"] * 9 + ["none"] * 9
    assert {one.manager for one in plan(replace(spec, score=False))} == {"baseline", "oracle"}


def test_a_program_that_is_started_by_hand_has_no_runs_of_others_beside_it() -> None:
    live = Settings(middleware="cyclonedds")
    spec = BenchSpec(suite="degraded", managers=("external",), references=False, repetitions=1, settings=live)

    assert {one.manager for one in plan(spec)} == {"external"}


def test_all_managing_systems_of_a_scenario_and_a_seed_are_started_together() -> None:
    managers = ("none", "baseline", "reactive")
    spec = BenchSpec(suite="degraded", managers=managers, references=False, score=False, repetitions=2)
    runs = in_turn(plan(spec))

    assert sorted(map(repr, runs)) == sorted(map(repr, plan(spec)))
    for begin in range(0, len(runs), 3):
        together = runs[begin : begin + 3]
        assert [one.manager for one in together] == list(managers)
        assert len({(one.scenario.name, one.seed) for one in together}) == 1
    assert [one.seed for one in runs] == [1] * 27 + [2] * 27


def test_some_scenarios_without_the_reference_rows() -> None:
    names = (
        "memory_leakage+image_shift+autofocus_needed",
        "artifact/gpu_failure+image_shift+autofocus_needed",
    )

    runs = plan(BenchSpec(suite="artifact", scenarios=names, references=False, score=False, repetitions=2))

    planned = [(one.scenario.name, one.manager) for one in runs if one.seed == 2]
    assert planned == [
        (f"artifact/{names[0]}", "none"),
        (names[1], "none"),
        (f"artifact/{names[0]}", "baseline"),
        (names[1], "baseline"),
    ]
    assert len(runs) == 2 * len(planned)


def test_a_scenario_of_another_suite_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="The suite artifact has no scenario 'nofault': see 'sunset"):
        plan(BenchSpec(suite="artifact", scenarios=("nofault",)))


def test_a_campaign_over_scenarios_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "rain.yaml").write_text("name: rainy evening\nfaults: [gpu_failure]\n", encoding="utf-8")
    (tmp_path / "sun.yaml").write_text("name: nofault\nfaults: []\n", encoding="utf-8")

    runs = plan(BenchSpec(suite=str(tmp_path), managers=("none", "baseline"), repetitions=1))

    assert [(one.suite, one.manager) for one in runs[10:]] == [
        ("", "none"),
        ("", "baseline"),
        ("nofault", "baseline"),
        ("", "oracle"),
        ("nofault", "oracle"),
    ]
    folders = [run_folder(Path("out"), one) for one in runs]
    assert len(set(folders)) == len(folders)
    assert {len(folder.parts) for folder in folders} == {6}


def test_a_part_of_a_split_is_said_to_be_one(tmp_path: Path) -> None:
    generate_split("test", 3, tmp_path / "split", seed=1)
    spec = BenchSpec(
        suite=str(tmp_path / "split"),
        scenarios=("test-0001",),
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
    )
    bench(spec, tmp_path / "out", jobs=1)

    (place,) = (tmp_path / "out").glob("runs/*/*/*/*")
    assert read_run(place).suite_size == 3
    assert "none [1 of 3 scenarios]" in sunset.report(tmp_path / "out")


def test_managing_systems_with_similar_names_do_not_share_a_folder() -> None:
    runs = plan(BenchSpec(suite="nofault", managers=("a/b.py:C", "a-b.py:C"), repetitions=1))

    assert len({run_folder(Path("out"), one) for one in runs}) == len(runs)


def test_the_last_seed_must_be_a_seed_too() -> None:
    with pytest.raises(InvalidInputError, match="4294967296"):
        BenchSpec(seed=2**32 - 1, repetitions=2)


@pytest.mark.thorough
@pytest.mark.xdist_group("campaign")
def test_killing_a_campaign_loses_nothing_and_changes_nothing(undisturbed: Path, tmp_path: Path) -> None:
    disturbed = tmp_path
    process = subprocess.Popen(
        bench_command(disturbed, "--jobs", "2"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    while len(list(disturbed.rglob("seed-*/run.json"))) < 4:
        assert process.poll() is None, "the campaign ended before it could be killed"
        time.sleep(0.02)  # noqa: TID251  the other process lives in wall time
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    finished = {path: path.stat().st_mtime_ns for path in disturbed.rglob("seed-*/run.json")}
    assert len(finished) < RUNS

    again = subprocess.run(
        bench_command(disturbed, "--jobs", "2"), check=True, capture_output=True, text=True
    )

    assert f"{RUNS - len(finished)} runs done, {len(finished)} were there already." in again.stderr
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert content_of(disturbed) == content_of(undisturbed)
    assert sunset.report(disturbed, "json") == sunset.report(undisturbed, "json")


def _processes_of(group: int) -> list[str]:
    """Return the commands that still run in a process group."""
    command = ["ps", "-eo", "pgid=,stat=,args="]
    listed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    lines = [line.split(maxsplit=2) for line in listed.splitlines()]
    return [line[2] for line in lines if line[0] == str(group) and not line[1].startswith("Z")]


@pytest.mark.thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_interrupted_campaign_leaves_no_process_behind(number: signal.Signals, tmp_path: Path) -> None:
    process = subprocess.Popen(
        bench_command(tmp_path, "--jobs", "2"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )
    while not list(tmp_path.rglob("seed-*/run.json")):
        assert process.poll() is None, "the campaign ended before it could be interrupted"
        time.sleep(0.02)  # noqa: TID251  the other process lives in wall time
    process.send_signal(number)
    error = process.communicate()[1]

    assert process.returncode == (-number if number is signal.SIGKILL else 128 + number)
    assert "Traceback" not in error
    deadline = time.monotonic() + 10
    while _processes_of(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)  # noqa: TID251  the other processes live in wall time
    assert not _processes_of(process.pid)


@pytest.mark.thorough
@pytest.mark.xdist_group("campaign")
def test_a_report_can_be_computed_from_the_records_again(undisturbed: Path) -> None:
    assert sunset.report(undisturbed, "json", recompute=True) == sunset.report(undisturbed, "json")


MANAGER = "from sunset.managing import NoAdaptation\n\n\nclass Mine(NoAdaptation):\n    pass\n"


EDITED = """
from pathlib import Path

from sunset.managing import NoAdaptation


class Mine(NoAdaptation):
    def on_start(self):
        with Path(__file__).open("a") as file:
            file.write("# another line\\n")
"""


@pytest.mark.thorough
def test_a_managing_system_cannot_change_itself(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(EDITED)
    spec = BenchSpec(
        suite="nofault",
        managers=(f"{file}:Mine", "none"),
        references=False,
        score=False,
        repetitions=2,
        settings=SHORT,
    )

    assert bench(spec, tmp_path / "out", jobs=1) == 4

    rows = json.loads(sunset.report(tmp_path / "out", "json"))["rows"]
    assert [(row["manager"], row["runs"], row["runs_failed"]) for row in rows] == [
        ("none", 2, 0),
        (f"{file}:Mine", 2, 2),
    ]
    assert all("PermissionError" in run["reason"] for run in rows[1]["failed"])
    assert file.read_text() == EDITED


@pytest.mark.thorough
def test_a_campaign_is_not_continued_with_a_managing_system_that_was_rewritten(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(MANAGER)
    managers = (f"{file}:Mine",)
    spec = BenchSpec(
        suite="nofault", managers=managers, references=False, score=False, repetitions=1, settings=SHORT
    )
    assert bench(spec, tmp_path / "out", jobs=1) == 1
    assert bench(spec, tmp_path / "out", jobs=1) == 0

    file.write_text(MANAGER + "\n# another one\n")

    with pytest.raises(InvalidInputError, match=r"mine\.py:Mine has changed since the campaign in "):
        bench(spec, tmp_path / "out", jobs=1)


@pytest.mark.usefixtures("flight")
def test_a_campaign_is_not_continued_by_other_code(tmp_path: Path) -> None:
    settings = Settings(timing=Timing(duration_s=1.0, warm_up_s=0.5))
    spec = BenchSpec(
        suite="single",
        scenarios=("image_shift",),
        managers=("none",),
        references=False,
        score=False,
        settings=settings,
    )
    bench(spec, tmp_path, jobs=1)
    file = tmp_path / "bench.json"
    plan = json.loads(file.read_text())
    version, plan["versions"]["sunset"] = plan["versions"]["sunset"], "0.1.0+0a0b0c0d"
    file.write_text(json.dumps(plan))

    with pytest.raises(
        InvalidInputError,
        match=rf"was begun with SUNSET 0\.1\.0\+0a0b0c0d, and this is {re.escape(version)}, whose code differs: go on",
    ):
        bench(spec, tmp_path, jobs=1)


@pytest.mark.thorough
def test_a_campaign_is_continued_with_the_same_extensions_only(tmp_path: Path) -> None:
    file, other = tmp_path / "dark.py", tmp_path / "light.py"
    for path in (file, other):
        path.write_text("from sunset.system import Extension\n\nEXTENSION = Extension()\n")
    spec = BenchSpec(
        suite="nofault", managers=("none",), references=False, score=False, repetitions=1, settings=SHORT
    )
    out = tmp_path / "out"

    def run_with(*extensions: Path) -> int:
        with extended_system([str(extension) for extension in extensions]):
            return bench(spec, out, jobs=1)

    assert run_with(file) == 1
    assert run_with(file) == 0
    with pytest.raises(InvalidInputError, match=r"was begun with the extension dark\.py; name the same"):
        run_with()
    with pytest.raises(InvalidInputError, match=r"was begun without the extension light\.py; name the same"):
        run_with(file, other)
    file.write_text(file.read_text() + "# another one\n")
    with pytest.raises(InvalidInputError, match=r"The extension dark\.py has changed since the campaign in "):
        run_with(file)


@pytest.mark.thorough
def test_a_campaign_says_in_what_it_differs(tmp_path: Path) -> None:
    spec = BenchSpec(
        suite="nofault", managers=("none",), references=False, score=False, repetitions=1, settings=SHORT
    )
    bench(spec, tmp_path / "out", jobs=1)
    with pytest.raises(
        InvalidInputError, match=r"its managers are 'none', this one's are 'none' and 'baseline'"
    ):
        bench(replace(spec, managers=("none", "baseline")), tmp_path / "out", jobs=1)
    with pytest.raises(InvalidInputError, match=r"its scenarios are not given, this one's are 'nofault'"):
        bench(replace(spec, scenarios=("nofault",)), tmp_path / "out", jobs=1)
    with pytest.raises(InvalidInputError, match=r"its seed is 1, this one's is 2"):
        bench(replace(spec, seed=2), tmp_path / "out", jobs=1)


@pytest.mark.thorough
def test_a_campaign_is_not_continued_with_another_bag(tmp_path: Path, flight: Path) -> None:
    bag = tmp_path / "bag"
    with read_bag(flight) as reader:
        frames = SHORT.timing.of_run(Scenario("nofault"), 1).frames
        write_bag(bag, map(reader.frame, range(frames)), reader.stamps_ns[:frames])
    spec = BenchSpec(
        suite="nofault",
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
        settings=replace(SHORT, bag=bag),
    )
    bench(spec, tmp_path / "out", jobs=1)

    metadata = bag / "metadata.yaml"
    metadata.write_text(metadata.read_text() + "\n")

    with pytest.raises(InvalidInputError, match="bag_checksum is"):
        bench(spec, tmp_path / "out", jobs=1)


@pytest.mark.thorough
def test_a_label_is_the_name_everywhere(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(MANAGER)
    managers = (f"mine={file}:Mine", "idle=none", "none")
    spec = BenchSpec(
        suite="nofault", managers=managers, references=False, score=False, repetitions=1, settings=SHORT
    )

    assert bench(spec, tmp_path / "out", jobs=1) == 3

    folders = sorted(folder.name for folder in (tmp_path / "out" / "runs" / "nofault").iterdir())
    assert folders == ["idle", "mine", "none"]
    record = read_run(next((tmp_path / "out").glob("runs/*/mine/*/seed-1")))
    assert (record.manager, record.manager_spec) == ("mine", f"{file}:Mine")
    planned = json.loads((tmp_path / "out" / "bench.json").read_text())
    assert sorted(planned["manager_checksums"]) == ["idle", "mine", "none"]
    rows = json.loads(sunset.report(tmp_path / "out", "json"))["rows"]
    assert [row["manager"] for row in rows] == ["none", "idle", "mine"]

    file.write_text(MANAGER + "\n# another one\n")

    with pytest.raises(InvalidInputError, match=r"The managing system mine has changed since"):
        bench(spec, tmp_path / "out", jobs=1)


def test_labels_must_differ() -> None:
    with pytest.raises(InvalidInputError, match="must be named once, got a, a"):
        BenchSpec(managers=("a=none", "a=baseline"))


def test_labels_must_differ_by_more_than_case() -> None:
    with pytest.raises(InvalidInputError, match="must be named once, got mine, Mine"):
        BenchSpec(managers=("mine=baseline", "Mine=reactive"))


def test_a_run_that_a_failing_computer_has_damaged_is_done_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    spec = BenchSpec(
        suite="nofault", managers=("none",), references=False, score=False, repetitions=2, settings=SHORT
    )
    assert bench(spec, tmp_path / "out", jobs=1) == 2
    before = content_of(tmp_path / "out")
    file = next((tmp_path / "out").rglob("seed-1/run.json"))
    file.write_bytes(bytes(file.stat().st_size))

    with pytest.raises(RecordError, match=r"Remove its folder, and the campaign's command runs it again\."):
        load_results(tmp_path / "out")
    assert bench(spec, tmp_path / "out", jobs=1) == 1
    assert content_of(tmp_path / "out") == before
    assert "run.json is damaged and cannot be read as JSON" in caplog.text
    assert "It is run again." in caplog.text


def test_a_folder_without_locks_for_files_is_said_to_be_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:  # as some network drives do
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", refused)
    rule = r"has no locks for files \(No locks available\), .* name a folder on another one"
    with pytest.raises(OutputError, match=rule), locked_campaign(tmp_path / "out"):
        pass


NO_SHARED_MEMORY = ["unshare", "--map-root-user", "--mount", "sh", "-c"]


@pytest.mark.thorough
def test_a_campaign_of_one_job_needs_no_shared_memory(tmp_path: Path) -> None:
    closed = "mount -t tmpfs -o ro none /dev/shm && "
    if subprocess.run([*NO_SHARED_MEMORY, f"{closed}true"], check=False, capture_output=True).returncode:
        pytest.skip("this system lets no user mount anything")
    for jobs, code, told in ((2, 2, "let /dev/shm be written to, or do with --jobs 1."), (1, 0, "")):
        command = [*bench_command(tmp_path / "out", "--no-references"), "--jobs", str(jobs)]
        done = subprocess.run(
            [*NO_SHARED_MEMORY, closed + shlex.join(command)], check=False, capture_output=True, text=True
        )
        assert (done.returncode, told in done.stderr) == (code, True), done.stderr


@pytest.mark.thorough
def test_a_campaign_without_references_is_another(tmp_path: Path) -> None:
    spec = BenchSpec(suite="nofault", managers=("none",), repetitions=1, settings=SHORT)
    bench(replace(spec, references=False, score=False), tmp_path / "out", jobs=1)

    with pytest.raises(InvalidInputError, match="its references is False"):
        bench(spec, tmp_path / "out", jobs=1)


@pytest.mark.thorough
def test_a_campaign_is_not_continued_with_another_clockwork(tmp_path: Path) -> None:
    spec = BenchSpec(suite="nofault", managers=("none",), references=False, score=False, repetitions=1)
    bench(replace(spec, settings=SHORT), tmp_path / "out", jobs=1)

    with pytest.raises(InvalidInputError, match=r"timing\.duration_s is 1\.0"):
        bench(spec, tmp_path / "out", jobs=1)


@pytest.mark.thorough
def test_a_campaign_is_run_by_one_process_at_a_time(tmp_path: Path) -> None:
    spec = BenchSpec(
        suite="nofault",
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
        settings=SHORT,
    )

    def another(done: int, _: int) -> None:
        if done == 0:
            with pytest.raises(OutputError, match="is being run by another process"):
                bench(spec, tmp_path / "out", jobs=1)

    assert bench(spec, tmp_path / "out", jobs=1, progress=another) == 1


TROUBLEMAKERS = {
    "RaisesInConstructor": r"it raised LookupError: nothing to begin with \(troublemakers.py, line \d+, in __init__\)",
    "RaisesInOnStart": r"it raised LookupError: nothing to start with \(troublemakers.py, line \d+, in on_start\)",
    "RaisesInAdapt": r"it raised KeyboardInterrupt \(troublemakers.py, line \d+, in adapt\)",
    "Exits": r"it raised SystemExit: enough \(troublemakers.py, line \d+, in adapt\)",
    "EndsItsProcess": r"it ended its process with exit code 0",
    "Hangs": r"it did not return within 20 s \(troublemakers.py, line \d+, in adapt\)",
}


HARMLESS = ("Forks", "Moves", "Patches", "Poisons")


@pytest.mark.thorough
def test_nothing_that_a_managing_system_does_ends_a_campaign_or_shows_in_the_runs_of_others(
    tmp_path: Path,
) -> None:
    file = Path(__file__).with_name("troublemakers.py")
    spec = BenchSpec(
        suite="nofault",
        managers=(*(f"{file}:{name}" for name in (*TROUBLEMAKERS, *HARMLESS)), "baseline"),
        references=False,
        score=False,
        repetitions=2,
        settings=replace(SHORT, manager_limit_s=2.0),
    )

    assert bench(spec, tmp_path / "out", jobs=1) == 22
    assert bench(replace(spec, managers=("baseline",)), tmp_path / "alone", jobs=1) == 2

    rows = {row["system"]: row for row in json.loads(sunset.report(tmp_path / "out", "json"))["rows"]}
    for name, reason in TROUBLEMAKERS.items():
        row = rows.pop(f"troublemakers.py:{name}, no faults [1 s]")
        assert (row["runs"], row["runs_invalid"], row["runs_failed"]) == (2, 0, 2)
        assert row["iou_all"]["mean"] > 0.3
        assert [run["seed"] for run in row["failed"]] == [1, 2]
        for run in row["failed"]:
            assert re.search(reason, run["reason"])
    for row in rows.values():  # a forked copy goes nowhere, and the baseline is the baseline
        assert (row["runs"], row["runs_failed"]) == (2, 0)
        assert row["iou"]["mean"] < 0.9
    assert len(rows) == 5
    alone = content_of(tmp_path / "alone" / "runs")
    assert alone
    together = content_of(tmp_path / "out" / "runs")
    assert {path: content for path, content in together.items() if path in alone} == alone

"""A whole run from its record."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec import to_builtins

from sunset.errors import RecordError
from sunset.metrics import score
from sunset.recording import read_stored_run, read_timeline
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.rcl_interfaces.msg import Log

Row = tuple[str, int, Message]
Write = Callable[[Path, list[Row]], Path]

START_NS = 3 * 10**9
ABOUT = {
    "scenario": "rain",
    "suite": "",
    "middleware": "sim",
    "model_checksums": {},
    "faults": [{"name": "gpu_failure", "value": None}, {"name": "image_shift", "value": 300}],
    "manager": "mine",
    "seed": 4,
    "model": "lite",
    "valid": False,
    "reason": "it looked",
}


def described(record: Path, **changes: object) -> Path:
    file = record / "run.json"
    found = score(read_timeline(record))
    figures = {"metrics": found.to_json(), "fault_outcomes": to_builtins(found.outcomes)}
    run = json.loads(file.read_text()) | ABOUT | figures | changes
    file.write_text(json.dumps({key: value for key, value in run.items() if value is not ...}))
    return record


def test_what_was_logged_has_the_experiments_time(
    rows: list[Row], tmp_path: Path, write_record: Write
) -> None:
    logged = [
        ("/rosout", START_NS - 10**9 // 4, Log(level=20, name="managing_system", msg="ready")),
        ("/rosout", START_NS + 5 * 10**8, Log(level=30, name="managed_subsystem.camera", msg="refused")),
        ("/rosout", START_NS + 6 * 10**8, Log(level=99, name="odd", msg="what")),
    ]
    record = write_record(tmp_path / "logs", sorted([*rows, *logged], key=lambda row: row[1]))

    lines = read_stored_run(described(record)).log

    assert [(line.time, line.logger) for line in lines] == [
        (-0.25, "managing_system"),
        (0.5, "managed_subsystem.camera"),
        (0.6, "odd"),
    ]
    assert [str(line) for line in lines] == ["ready", "WARN: refused", "99: what"]


def test_a_run_is_what_its_record_tells(record: Path) -> None:
    run = read_stored_run(described(record))

    about = run.record
    faults = [(fault.name, fault.value) for fault in about.faults]
    assert (about.scenario, faults) == ("rain", [("gpu_failure", None), ("image_shift", 300)])
    assert (about.manager, about.seed, about.model) == ("mine", 4, "lite")
    assert (run.valid, run.reason, run.log) == (False, "it looked", ())
    assert run.metrics == score(read_timeline(record))
    assert [injection.fault for injection in run.timeline.injections] == ["hardware_disconnect"]


@pytest.mark.parametrize("key", ABOUT)
@pytest.mark.parametrize(("value", "got"), [(..., "nothing"), (1.5, "1.5")])
def test_a_record_that_does_not_tell_is_refused(record: Path, key: str, value: object, got: str) -> None:
    with pytest.raises(
        RecordError, match=rf"^The {key} in .*/run\.json must be .*, got {got}; restore the file, or"
    ):
        read_stored_run(described(record, **{key: value}))


def test_a_seed_that_is_no_number_is_refused_and_its_text_is_cut(record: Path) -> None:
    for seed in (True, "1" * 10_000):
        with pytest.raises(RecordError, match=r"The seed in .* must be a whole number, got") as found:
            read_stored_run(described(record, seed=seed))
        assert len(str(found.value)) < 300


def test_figures_that_differ_from_the_messages_are_named(record: Path) -> None:
    metrics = score(read_timeline(record))
    assert read_stored_run(described(record)).differing == ()
    for figure, value in (("adaptations", 99), ("iou", 7)):
        run = read_stored_run(described(record, metrics=metrics.to_json() | {figure: value}))
        assert (run.differing, run.metrics) == ((figure,), metrics)


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        ([{}], r"The faults\.0\.name in .* must be a text, got nothing"),
        ([{"name": "a"}, "gpu_failure"], r"The faults\.1 in .* must be an object, got 'gpu_failure'"),
        ([None], r"The faults\.0 in .* must be an object, got None"),
    ],
)
def test_faults_without_a_name_are_refused(record: Path, faults: object, message: str) -> None:
    with pytest.raises(RecordError, match=message):
        read_stored_run(described(record, faults=faults))


def test_what_stands_in_the_place_of_a_failed_run_has_no_time_line(record: Path) -> None:
    reason = "The managing system mine.py:Mine failed: it raised KeyError."
    with pytest.raises(RecordError, match=r"has no time line, since it failed: The .* KeyError\."):
        read_stored_run(described(record, manager_failed=reason, start_ns=...))
    with pytest.raises(RecordError) as found:
        read_stored_run(described(record, manager_failed="it raised " * 1000, start_ns=...))
    assert len(str(found.value)) < 1500


def test_a_run_that_went_on_without_a_managing_system_says_so(record: Path) -> None:
    reason = "The managing system mine.py:Mine failed: it raised KeyError."
    run = read_stored_run(described(record, manager_failed=reason, start_ns=0))
    assert f"{reason} The run went on without it." in str(run)
    assert run.summary()["manager_failed"] == reason

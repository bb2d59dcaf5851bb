import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import sunset
from sunset.errors import RecordError
from sunset.evaluation.results import FIGURES, Flight, load_results
from sunset.metrics import Timeline, score

Store = Callable[..., Path]
Edit = Callable[..., None]


def test_a_run_is_read_from_its_folder_or_from_any_above(store: Store, tmp_path: Path) -> None:
    folder = store("runs/paper/baseline/seed-1")
    (row,) = load_results(folder)
    assert load_results(tmp_path) == [row]
    assert (row.scenario, row.suite, row.manager, row.seed) == (
        "paper/camera_driver_issue",
        "paper",
        "baseline",
        1,
    )
    assert (row.model, row.middleware, row.valid, row.reason) == ("lite", "sim", True, "")
    assert row.digest == json.loads((folder / "run.json").read_text())["digest"]


def test_stored_and_recomputed_figures_agree_and_are_right(store: Store) -> None:
    folder = store("run")
    (stored,), (again,) = load_results(folder), load_results(folder, again=True)
    assert dict(stored.metrics) == dict(again.metrics)
    # silent from 1.9 to 6.0, symptom at 2.9, injected at 2.0, redeployed at 3.5: F1 from 2.0, its ripples
    # F2 and F3 from 1.9; the redeploy was not necessary; 40 frames of 200 are missing
    assert stored.metrics["t_react_s"] == pytest.approx((1.5 + 1.6 + 1.6) / 3)
    assert stored.metrics["f_resolved_per_adaptation"] == 3.0
    assert stored.metrics["redeploys_unnecessary"] == 1
    assert stored.metrics["t_down_s"] == pytest.approx(4.1)
    assert stored.metrics["iou"] == pytest.approx(0.5)
    assert stored.metrics["iou_all"] == pytest.approx(0.4)


def test_recomputing_does_not_believe_what_is_stored(store: Store, edit: Edit) -> None:
    folder = store("run")
    (honest,) = load_results(folder)
    edit(folder, metrics=dict(honest.metrics) | {"t_down_s": 0.0})
    assert load_results(folder)[0].metrics["t_down_s"] == 0.0
    assert load_results(folder, again=True)[0].metrics == honest.metrics


def test_recomputing_needs_no_stored_figures(store: Store, edit: Edit) -> None:
    folder = store("run")
    edit(folder, metrics={})
    assert load_results(folder, again=True)[0].metrics["t_down_s"] == pytest.approx(4.1)
    with pytest.raises(
        RecordError, match=r"f_resolved_per_adaptation in .* nothing; run it again, or use --recompute"
    ):
        load_results(folder)


def test_the_figures_are_those_that_runs_have() -> None:
    empty = Timeline(thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1})
    assert tuple(score(empty).to_json()) == FIGURES


def test_the_same_run_twice_counts_once_and_another_seed_counts(store: Store, tmp_path: Path) -> None:
    store("a/run")
    store("b/run")
    store("c/run", seed=2, iou=0.3)
    assert [row.seed for row in load_results(tmp_path)] == [1, 2]


def test_unfinished_runs_are_not_looked_at(store: Store, tmp_path: Path) -> None:
    store("runs/.seed-2.partial", seed=2)
    store("runs/seed-1")
    assert [row.seed for row in load_results(tmp_path)] == [1]


def test_a_hidden_folder_can_be_named_itself(store: Store) -> None:
    assert len(load_results(store(".results/run").parent)) == 1


def test_extensions_that_differ_are_told_apart_as_what_they_are(store: Store, tmp_path: Path) -> None:
    store("plain")
    store("extended", extensions={"altimeter": "0f" * 32})
    store("edited", extensions={"altimeter": "1e" * 32, "buoy": "2d" * 32})
    rows = load_results(tmp_path)
    assert {row.model for row in rows} == {"lite"}
    plain = rows[-1].version
    assert [row.version for row in rows] == [
        f"{plain} with altimeter 1e1e1e1e and buoy 2d2d2d2d",
        f"{plain} with altimeter 0f0f0f0f",
        plain,
    ]
    assert f"[sunset {plain} with altimeter 0f0f0f0f]" in sunset.report(tmp_path)


def test_models_of_one_name_that_differ_are_told_apart(store: Store, tmp_path: Path) -> None:
    store("shipped", model_checksums={"fusion": "0f"})
    store("trained", model_checksums={"fusion": "1e"})
    store("calibrated", entropy_threshold=0.3)
    store("another", model="mine", model_checksums={"fusion": "2d"})
    models = [row.model for row in load_results(tmp_path)]
    assert len(set(models)) == 4
    assert models.count("mine") == 1


def test_another_flight_or_time_is_no_other_model(store: Store, tmp_path: Path) -> None:
    store("plain", bag_checksum="3c" * 32)
    store("elsewhere", bag_checksum="7e" * 32)
    store("looped", bag_looped=True)
    store("long", duration_s=24.0)
    rows = {row.folder.name: row for row in load_results(tmp_path)}
    assert {row.model for row in rows.values()} == {"lite"}
    assert rows["plain"].flight == Flight(20.0, looped=False, bag="3c" * 32)
    assert rows["elsewhere"].flight == Flight(20.0, looped=False, bag="7e" * 32)
    assert rows["looped"].flight == Flight(20.0, looped=True)
    assert rows["long"].flight == Flight(24.0)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("duration_s", ..., "The duration_s in .* must be a number above 0"),
        ("bag_looped", "no", "The bag_looped in .* must be true or false"),
        ("bag_checksum", 3, "The bag_checksum in .* must be a text"),
    ],
)
def test_a_flight_that_is_told_otherwise_is_refused(
    store: Store, edit: Edit, key: str, value: object, message: str
) -> None:
    folder = store("run")
    edit(folder, **{key: value})
    with pytest.raises(RecordError, match=message):
        load_results(folder)


def test_managing_systems_and_scenarios_of_one_name_that_differ_are_told_apart(
    store: Store, tmp_path: Path
) -> None:
    store("first", manager="mine.py:Mine", manager_checksum="0f0f0f0f0f")
    store("rewritten", manager="mine.py:Mine", manager_checksum="1e1e1e1e1e")
    store("harder", scenario="a", faults=[{"name": "gpu_failure", "value": True}])
    store("easier", scenario="a", faults=[])
    rows = {row.folder.name: row for row in load_results(tmp_path)}
    assert rows["first"].manager == "mine.py:Mine 0f0f0f0f"
    assert rows["rewritten"].manager == "mine.py:Mine 1e1e1e1e"
    assert rows["first"].scenario == rows["rewritten"].scenario
    assert rows["harder"].scenario != rows["easier"].scenario


def test_a_run_says_which_version_flew_it(store: Store, tmp_path: Path) -> None:
    store("old", versions={"sunset": "0.9.0", "numpy": "2.0.0"})
    store("older", seed=2)
    found = {row.folder.name: row.version for row in load_results(tmp_path)}
    assert found == {"old": "0.9.0", "older": ""}


def test_runs_that_should_have_the_same_messages_and_have_not_are_named(store: Store, tmp_path: Path) -> None:
    versions = {"sunset": "0.9.0+0f0f0f0f", "numpy": "2.0.0"}
    about: dict[str, Any] = {"manager_checksum": "0f" * 32, "versions": versions}
    store("first", **about)
    store("copy", **about)
    other = store("other", iou=0.6, **about | {"versions": versions | {"numpy": "2.1.0"}})
    store("another version", iou=0.7, **about | {"versions": {"sunset": "0.9.0+1e1e1e1e"}})
    store("another seed", seed=2, iou=0.8, **about)

    text = " ".join(sunset.report(tmp_path).split())

    assert "runs of the same scenario, seed, managing system and version have different messages" in text
    assert text.count(" and ".join(map(str, sorted([tmp_path / "copy", other])))) == 1
    assert "its runs were made with several versions of numpy (2.0.0, 2.1.0)." in text
    assert "[sunset 0.9.0+1e1e1e1e]" in text


def test_a_scenario_of_ones_own_is_of_no_suite_whatever_its_name(store: Store) -> None:
    (row,) = load_results(store("run", scenario="nofault", suite=""))
    assert row.suite == ""


def test_progress_is_told_after_each_run(store: Store, tmp_path: Path) -> None:
    store("a")
    store("b", seed=2)
    told: list[tuple[int, int]] = []
    load_results(tmp_path, progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]


def test_a_missing_folder_and_an_empty_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=r"There is no folder .*nowhere; name the one that"):
        load_results(tmp_path / "nowhere")
    with pytest.raises(RecordError, match=r"There is no finished run below"):
        load_results(tmp_path)


def test_a_truncated_file_is_refused_with_its_name(store: Store) -> None:
    folder = store("run")
    text = (folder / "run.json").read_text()
    (folder / "run.json").write_text(text[: len(text) // 2])
    with pytest.raises(RecordError, match=r"run/run\.json is damaged"):
        load_results(folder)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("scenario", ..., r"The scenario in .*run\.json must be a text, got nothing"),
        ("seed", "1", "The seed in .* must be a whole number, got '1'"),
        ("seed", True, "The seed in .* must be a whole number, got True"),
        ("valid", "yes", "The valid in .* must be true or false"),
        ("metrics", [], "The metrics in .* must be an object"),
        ("versions", "none", "The versions in .* must be an object, got 'none'"),
        ("record_version", 99, "version 99"),
    ],
)
def test_a_file_of_another_form_is_refused(
    store: Store, edit: Edit, key: str, value: object, message: str
) -> None:
    folder = store("run")
    edit(folder, **{key: value})
    with pytest.raises(RecordError, match=message):
        load_results(folder)


@pytest.mark.parametrize("value", ["fast", True, 7, -0.1, pytest.param(10**400, id="10^400")])
def test_a_figure_that_no_run_can_have_is_refused(store: Store, edit: Edit, value: object) -> None:
    folder = store("run")
    (row,) = load_results(folder)
    edit(folder, metrics=dict(row.metrics) | {"iou": value})
    with pytest.raises(
        RecordError, match=r"The metrics\.iou in .* must be a number from 0 to 1 or null"
    ) as found:
        load_results(folder)
    assert len(str(found.value)) < 300


@pytest.mark.parametrize(
    ("name", "value"),
    [("t_down_s", 1e308), pytest.param("adaptations", 10**400, id="10^400"), ("episodes", -1)],
)
def test_a_figure_out_of_all_proportion_is_refused(store: Store, edit: Edit, name: str, value: float) -> None:
    folder = store("run")
    (row,) = load_results(folder)
    edit(folder, metrics=dict(row.metrics) | {name: value})
    with pytest.raises(
        RecordError, match=rf"The metrics\.{name} in .* must be a (whole )?number from 0 to 1e\+06 or null"
    ):
        load_results(folder)


@pytest.mark.parametrize("value", [1e300, pytest.param(10**400, id="10^400"), 0, True])
def test_a_duration_that_no_run_has_is_refused(store: Store, edit: Edit, value: object) -> None:
    folder = store("run")
    edit(folder, duration_s=value)
    with pytest.raises(
        RecordError, match=r"The duration_s in .* must be a number above 0 and at most 1e\+06"
    ):
        load_results(folder, again=True)


def copy(folder: Path, name: str) -> Path:
    return Path(shutil.copytree(folder, folder.parent / name))


def test_runs_whose_managing_system_failed_have_no_messages_and_are_no_copies(
    store: Store, edit: Edit, tmp_path: Path
) -> None:
    for seed in (1, 2):
        edit(
            store(f"{seed}", seed=seed),
            manager_failed="it raised",
            start_ns=...,
            valid=False,
            digest="0" * 64,
        )
    copy(tmp_path / "1", "again")
    assert [row.seed for row in load_results(tmp_path, again=True)] == [1, 2]


def test_what_recomputing_corrects_is_named(store: Store, edit: Edit) -> None:
    folder = store("run")
    (honest,) = load_results(folder, again=True)
    edit(folder, metrics=dict(honest.metrics) | {"t_down_s": 0.0, "adaptations": "none"})
    (row,) = load_results(folder, again=True)
    assert (honest.differing, row.differing) == ((), ("t_down_s", "adaptations"))


def test_last_digits_of_another_computer_do_not_differ(store: Store, edit: Edit) -> None:
    folder = store("run")
    (honest,) = load_results(folder)
    edit(folder, metrics=dict(honest.metrics) | {"iou_all": 0.4 + 1e-13})
    assert load_results(folder, again=True)[0].differing == ()

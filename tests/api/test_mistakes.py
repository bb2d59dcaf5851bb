"""What people get wrong in Python: every mistake is a `SunsetError` with one sentence that says what to do."""

import functools
import json
import multiprocessing
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import sunset
from sunset import ManagingSystem, Symptoms
from sunset.errors import SunsetError
from sunset.scenarios import Scenario, ScenarioFault


class Good(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        del symptoms


class WithoutAdapt(ManagingSystem):
    pass


class WithoutSymptoms(ManagingSystem):
    def adapt(self) -> None:  # type: ignore[override]
        pass


class Yielding(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> Iterator[None]:  # type: ignore[override]
        yield


class OwnConstructor(ManagingSystem):
    def __init__(self, gain: float) -> None:
        self.gain = gain
        super().__init__()

    def adapt(self, symptoms: Symptoms) -> None:
        del symptoms


class NoManager:
    def adapt(self, symptoms: Symptoms) -> None:
        del symptoms


api: Any = sunset  # the mistakes are of types, too

Mistake = Callable[[Path], object]

RUNS: dict[str, tuple[Mistake, str]] = {
    "unknown scenario": (lambda _: api.run("gpu_failur"), "did you mean 'gpu_failure'"),
    "factory with an argument that is not known": (
        lambda _: api.run("gpu_failure", functools.partial(OwnConstructor, loss=1)),  # type: ignore[call-arg]
        "cannot make a managing system",
    ),
    "suite as scenario": (lambda _: api.run("paper"), "is a suite"),
    "no scenario": (lambda _: api.run(None), "A scenario must be a name"),
    "list of faults": (lambda _: api.run(["gpu_failure"]), "faults joined by [+]"),
    "number as scenario": (lambda _: api.run(3), "A scenario must be a name"),
    "empty scenario": (lambda _: api.run(""), "scenario"),
    "scenario with a long name": (lambda _: api.run("x" * 300), "There is no scenario 'xxx"),
    "missing scenario file": (lambda folder: api.run(folder / "rain.yaml"), "rain.yaml"),
    "folder as scenario": (api.run, "scenario"),
    "unknown manager": (lambda _: api.run(manager="basline"), "did you mean 'baseline'"),
    "no manager": (lambda _: api.run(manager=None), "pass the class itself"),
    "number as manager": (lambda _: api.run(manager=7), "A managing system must be a name"),
    "module as manager": (lambda _: api.run(manager=json), "A managing system must be a name"),
    "class of another kind": (lambda _: api.run(manager=NoManager), "must be a subclass of ManagingSystem"),
    "base class as manager": (lambda _: api.run(manager=ManagingSystem), "has no method adapt"),
    "class without adapt": (
        lambda _: api.run(manager=WithoutAdapt),
        r"has no method adapt\(self, symptoms\)",
    ),
    "adapt without symptoms": (
        lambda _: api.run(manager=WithoutSymptoms),
        "must accept one argument, symptoms",
    ),
    "adapt that yields": (lambda _: api.run(manager=Yielding), "contains yield"),
    "constructor of one's own": (lambda _: api.run(manager=OwnConstructor), "__init__ must accept context"),
    "function without options": (lambda _: api.run(manager=lambda: None), "must accept context"),
    "missing manager file": (lambda folder: api.run(manager=f"{folder}/mine.py:Mine"), "There is no file"),
    "file without class": (lambda folder: api.run(manager=f"{folder}/mine.py"), "name its class too"),
    "instance in place of its class": (
        lambda _: api.run(manager=Good()),
        "pass the class Good, not an instance",
    ),
    "class in a live run": (
        lambda _: api.run(manager=Good, middleware="cyclonedds"),
        "live, name it FILE.py:Class or module:Class",
    ),
    "external in the simulation": (lambda _: api.run(manager="external"), "can manage a live run only"),
    "seed as text": (lambda _: api.run(seed="1"), "A seed must be a whole number"),
    "seed as fraction": (lambda _: api.run(seed=1.5), "A seed must be a whole number"),
    "negative seed": (lambda _: api.run(seed=-1), "A seed must be a whole number"),
    "seed as truth": (lambda _: api.run(seed=True), "A seed must be a whole number"),
    "seed of no end": (lambda _: api.run(seed=10**5000), "got a whole number of thousands of digits"),
    "no seed": (lambda _: api.run(seed=None), "A seed must be a whole number"),
    "unknown option": (lambda _: api.run(durations=3), "did you mean 'duration'"),
    "duration as text": (lambda _: api.run(duration="20"), "The duration must be a number, got '20'"),
    "duration as truth": (lambda _: api.run(duration=True), "The duration must be a number, got True"),
    "duration of nothing": (lambda _: api.run(duration=0), "must be from 1 to 3600 s"),
    "duration between frames": (lambda _: api.run(duration=2.05), "a multiple of 0.1 s"),
    "model with a long name": (lambda _: api.run(model="x" * 300), "There is no model 'xxx"),
    "unknown model": (lambda _: api.run(model="lit"), "did you mean 'lite'"),
    "number as model": (lambda _: api.run(model=1), "The model must be a text, got 1"),
    "folder without card": (lambda folder: api.run(model=folder), "card.json is missing"),
    "missing bag": (lambda folder: api.run(bag=folder / "bag"), "bag"),
    "number as bag": (lambda _: api.run(bag=3), "The bag must be a path, got 3"),
    "loop as text": (lambda _: api.run(loop="yes"), "The loop must be true or false, got 'yes'"),
    "cache as number": (lambda _: api.run(cache=0), "The cache must be true or false, got 0"),
    "unknown device": (lambda _: api.run(device="gpu"), "gpu"),
    "no time to think": (lambda _: api.run(manager_limit=0), "time limit .* must be a number above 0"),
    "negative thoughts": (
        lambda _: api.run(thinking=-1),
        r"time to think \[s\] must be a number from 0 to 3600, got -1",
    ),
    "thoughts that are no number": (lambda _: api.run(thinking=float("nan")), "from 0 to 3600, got nan"),
    "thoughts longer than the run": (
        lambda _: api.run(duration=2, thinking=3),
        "must be at most the duration that is measured, 2 s, got 3 s",
    ),
    "unknown middleware": (lambda _: api.run(middleware="dds"), "The middleware must be sim or"),
    "rate of a simulation": (lambda _: api.run(rate=2.0), "The rate applies to live runs only"),
    "viewers of a simulation": (lambda _: api.run(viewers=["/rviz"]), "Viewers watch live runs only"),
    "viewers in one text": (lambda _: api.run(viewers="/rviz"), "viewers must be a list"),
    "rate of nothing": (lambda _: api.run(rate=0), "rate of a live run must be a number from 0.01 to 100"),
    "number as extension": (
        lambda _: api.run(extensions=3),
        "extensions must be a path, a name, or a list of them",
    ),
    "number among extensions": (lambda _: api.run(extensions=[3]), "The extension must be a path, got 3"),
    "empty extension": (lambda _: api.run(extensions=""), "The extension must be a path, got ''"),
    "missing extension": (lambda folder: api.run(extensions=folder / "x.py"), "There is no extension .*x.py"),
    "extension that is not installed": (lambda _: api.run(extensions=["x"]), "There is no extension 'x'"),
    "record over a record": (lambda folder: api.run("nofault", out=filled(folder)), "exists already"),
    "number as folder": (lambda _: api.run(out=3), "folder of the record must be a path, got 3"),
}


def filled(folder: Path) -> Path:
    (folder / "notes.txt").write_text("mine")
    return folder


CAMPAIGNS: dict[str, tuple[Mistake, str]] = {
    "unknown suite": (lambda folder: api.bench("papers", out=folder / "x"), "papers"),
    "number as suite": (
        lambda folder: api.bench(3, out=folder / "x"),
        "The suite must be the name of a suite or a folder",
    ),
    "scenarios as suite": (
        lambda folder: api.bench([Scenario("nofault")], out=folder / "x"),
        "The suite must be the name of a suite or a folder of scenario files, got",
    ),
    "suite with a long name": (lambda folder: api.bench("x" * 300, out=folder), "There is no suite 'xxx"),
    "empty suite": (lambda folder: api.bench("", out=folder / "x"), "There is no suite ''"),
    "empty scenarios": (lambda folder: api.bench(scenarios="", out=folder / "x"), "leave them out for all"),
    "list of an empty scenario": (
        lambda folder: api.bench(scenarios=[""], out=folder / "x"),
        "leave them out for all",
    ),
    "scenarios that are a comma": (
        lambda folder: api.bench(scenarios=",", out=folder / "x"),
        "leave them out for all",
    ),
    "a class in live runs": (
        lambda folder: api.bench(managers={"good": Good}, middleware="cyclonedds", out=folder),
        "live, name it FILE.py:Class",
    ),
    "unknown scenario of a suite": (
        lambda folder: api.bench("nofault", scenarios=["rain"], out=folder / "x"),
        "has no scenario 'rain'",
    ),
    "scenarios that are no names": (lambda folder: api.bench(scenarios=[1], out=folder), "a list of names"),
    "no managers": (lambda folder: api.bench(managers=[], out=folder), "must be named once, got none at all"),
    "a manager twice": (
        lambda folder: api.bench(managers=["none", "none"], out=folder),
        "must be named once",
    ),
    "an unknown manager": (lambda folder: api.bench("nofault", ["non"], out=folder), "did you mean 'none'"),
    "a label that is taken": (
        lambda folder: api.bench(managers={"none": Good}, out=folder),
        "comes with SUNSET",
    ),
    "a label with a blank": (lambda folder: api.bench(managers={"my own": Good}, out=folder), "label"),
    "a label that is no text": (
        lambda folder: api.bench(managers={1: Good}, out=folder),
        "labels .* must be texts",
    ),
    "two functions of one name": (
        lambda folder: api.bench(managers=[lambda **_: None, lambda **_: None], out=folder),
        "Two managing systems are called",
    ),
    "too many repetitions": (
        lambda folder: api.bench(repetitions=10**6, out=folder),
        "at most 1000, got 1000000",
    ),
    "no repetitions": (lambda folder: api.bench(repetitions=0, out=folder), "at least 1 repetition"),
    "repetitions as text": (lambda folder: api.bench(repetitions="3", out=folder), "must be a whole number"),
    "references as text": (lambda folder: api.bench(references="no", out=folder), "must be true or false"),
    "jobs of nobody": (lambda folder: api.bench(jobs=0, out=folder), "at least 1 job"),
    "jobs as truth": (lambda folder: api.bench(jobs=True, out=folder), "at least 1 job, got True"),
    "jobs as text": (lambda folder: api.bench(jobs="2", out=folder), "at least 1 job, got '2'"),
    "folder of something else": (
        lambda folder: api.bench("nofault", out=filled(folder)),
        "holds no campaign",
    ),
    "campaign into a file": (
        lambda folder: api.bench("nofault", out=filled(folder) / "notes.txt"),
        "notes.txt",
    ),
}

STORED: dict[str, tuple[Mistake, str]] = {
    "nothing there": (lambda folder: api.load(folder / "nowhere"), "There is no folder"),
    "an empty folder": (api.load, "There is no finished run below"),
    "a file": (lambda folder: api.load(filled(folder) / "notes.txt"), "A record is a folder, got the file"),
    "a number": (lambda _: api.load(3), "must be a path, got 3"),
    "no path": (lambda _: api.load(""), "must be a path, got ''"),
    "a run of another version": (
        lambda folder: api.load(versioned(folder, 99)),
        "is of version 99, expected 1; read it with the SUNSET that wrote it",
    ),
    "a report of nothing": (api.report, "There is no finished run below"),
}


def versioned(folder: Path, version: int) -> Path:
    (folder / "run.json").write_text(json.dumps({"record_version": version}))
    return folder


OTHERS: dict[str, tuple[Mistake, str]] = {
    "scenarios of no suite": (lambda _: api.list_scenarios("papers"), "papers"),
    "scenarios of a number": (lambda _: api.list_scenarios(3), "suite must be"),
    "scenarios of an empty suite": (lambda _: api.list_scenarios(""), "There is no suite ''"),
    "scenario as number": (lambda _: api.load_scenario(3), "A scenario must be a name"),
    "scenario of a name": (lambda _: Scenario("x", "gpu_failure"), "sunset.make_scenario"),  # type: ignore[arg-type]
    "scenario whose name is a number": (lambda _: api.make_scenario(name=3), "name must be a text, got 3"),
    "fault without a name": (lambda _: ScenarioFault(None), "name must be a text, got None"),  # type: ignore[arg-type]
    "strength as list": (lambda _: ScenarioFault("image_shift", [1]), "value must be true or false"),  # type: ignore[arg-type]
    "model as number": (lambda _: api.load_model(3), "A model must be a name or a folder, got 3"),
    "curves of a number": (lambda _: api.measure_curves(3), "A model must be a name or a folder, got 3"),
    "curves of no groups": (
        lambda _: api.measure_curves("lite", every=0),
        "groups of frames must be a whole one",
    ),
    "curves at no number": (
        lambda _: api.measure_curves("lite", strengths={"image_shift": "wide"}),
        "The strengths must be numbers by fault",
    ),
    "curves at a text": (
        lambda _: api.measure_curves("lite", strengths="image_shift=8"),
        "The strengths must be numbers by fault",
    ),
    "IoU of a number": (lambda _: api.measure_iou(3), "The models must be a list of names or folders, got 3"),
    "IoU of one unknown model": (lambda _: api.measure_iou("lit"), "There is no model 'lit'"),
    "IoU of no frames": (lambda _: api.measure_iou("lite", frames=0), "frames must be a whole one from 1 on"),
    "calibration of a number": (
        lambda _: api.calibrate_model(3),
        "A model must be a name or a folder, got 3",
    ),
    "unknown fault": (lambda _: api.make_scenario("gpu_failur"), "did you mean 'gpu_failure'"),
    "strength of a switch": (lambda _: api.make_scenario("gpu_failure=3"), "gpu_failure"),
    "number as fault": (lambda _: api.make_scenario(3), "The faults must be a list of names"),
    "no such model": (lambda _: api.load_model("lit"), "did you mean 'lite'"),
    "no such scenario": (lambda _: api.load_scenario("rain"), "There is no scenario 'rain'"),
    "a check of nothing": (lambda _: api.check_manager(None), "pass the class itself"),
    "a check of a class without adapt": (lambda _: api.check_manager(WithoutAdapt), "has no method adapt"),
    "statistics of no bag": (lambda folder: api.bag_statistics(folder / "bag"), "bag"),
    "a flight of another town": (
        lambda folder: api.render_flight(folder / "bag", api.FlightPlan(town=99)),
        "town",
    ),
    "a flight without a plan": (lambda folder: api.render_flight(folder / "bag", 3), "FlightPlan"),
    "a figure of another kind": (lambda folder: api.fault_figure(folder / "figure.doc"), "doc"),
    "curves of no extension": (lambda _: api.measure_curves("lite", extensions="x"), "no extension 'x'"),
    "curves of no model": (lambda _: api.measure_curves("lit"), "did you mean 'lite'"),
    "a training of no model": (lambda folder: api.train_model("lit", folder), "did you mean 'lite'"),
    "a training of no network": (
        lambda folder: api.train_model("lite", folder, modality="lidar"),
        "choose among all, rgb, depth, fusion",
    ),
    "a training of no steps": (
        lambda folder: api.train_model("lite", folder, steps=0),
        "steps must be a whole one from 1 on, got 0",
    ),
    "an import of no size": (
        lambda folder: api.import_model(folder, folder / "model", size=256),
        "width and height in pixels",
    ),
    "an import into a folder that exists": (lambda folder: api.import_model(folder, folder), "exists"),
    "an agreement of a class": (
        lambda folder: api.agree(managers=Good, out=folder / "x"),
        "live, name it FILE.py:Class",
    ),
    "an agreement of an unknown suite": (lambda folder: api.agree("x", out=folder), "There is no suite 'x'"),
    "an agreement of no process": (lambda folder: api.agree(jobs=0, out=folder), "at least 1 job"),
    "an agreement of one middleware": (
        lambda folder: api.agree(middleware="sim", out=folder),
        "leave the middleware out",
    ),
}


@pytest.mark.usefixtures("flight")
@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        pytest.param(*entry, id=name)
        for table in (RUNS, CAMPAIGNS, STORED, OTHERS)
        for name, entry in table.items()
    ],
)
def test_a_mistake_is_told_in_one_sentence(mistake: Mistake, words: str, tmp_path: Path) -> None:
    with pytest.raises(SunsetError, match=words) as found:
        mistake(tmp_path)

    sentence = str(found.value)
    assert sentence.endswith((".", "…"))
    assert "\n" not in sentence
    assert "Traceback" not in sentence
    assert 20 < len(sentence) < 600


def test_an_instance_in_place_of_its_class_is_told() -> None:
    manager = ManagingSystem.__new__(Good)

    with pytest.raises(SunsetError, match="pass the class itself, without parentheses"):
        api.run(manager=manager)


def test_fifty_mistakes_are_tried() -> None:
    assert sum(map(len, (RUNS, CAMPAIGNS, STORED, OTHERS))) >= 50


CALLS = {
    "run": 'sunset.run("nofault", "none", duration=1)',
    "bench": 'sunset.bench("nofault", ["none"], out="results", references=False, score=False, duration=1, jobs=2)',
    "check_manager": 'sunset.check_manager("none", "nofault", duration=1)',
}


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_script_needs_neither_a_guard_nor_a_file(call: str, tmp_path: Path) -> None:
    text = f"import sunset\n\nprint(type({call}).__name__)\n"
    (tmp_path / "script.py").write_text(text, encoding="utf-8")

    run = functools.partial(subprocess.run, check=False, capture_output=True, text=True, timeout=120)
    of_file = run([sys.executable, "script.py"], cwd=tmp_path)
    (tmp_path / "empty").mkdir()
    of_input = run([sys.executable], input=text, cwd=tmp_path / "empty")

    assert [of_file.returncode, of_input.returncode] == [0, 0], of_file.stderr + of_input.stderr
    assert of_file.stdout == of_input.stdout
    assert of_file.stdout.count("\n") == 1


def _bench(out: Path) -> str:
    with pytest.raises(SunsetError) as caught:
        sunset.bench("nofault", ["none"], out=out, references=False, score=False, duration=1)
    return str(caught.value)


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_a_process_that_can_have_no_workers_is_told_what_can(tmp_path: Path) -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        sentence = pool.apply(_bench, (tmp_path / "results",))

    assert sentence.startswith(
        "A daemonic process, such as one of multiprocessing.Pool, can have no worker processes"
    )

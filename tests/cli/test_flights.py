"""Flights on the command line: what cannot be flown is said in one sentence, and a campaign has what was finished."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.data import read_bag, write_bag
from sunset.evaluation.results import load_results
from sunset.experiments import BenchSpec, Settings, Timing, bench, count_runs
from sunset.recording import read_plan, read_run

FRAMES = 80
CAMPAIGN = (
    "bench",
    "--suite",
    "nofault",
    "--managers",
    "none",
    "--no-references",
    "--no-score",
    "--repetitions",
    "1",
)

BAD = {
    "unknown town": (
        ["data", "render", "--town", "9"],
        "The flight's town must be a whole number from 1 to 8, got 9.",
    ),
    "height of nothing": (
        ["data", "render", "--height", "0"],
        "The flight's height [m] must be a number from 20 to 300, got 0.0.",
    ),
    "angle behind": (
        ["data", "render", "--angle", "120"],
        "The flight's angle [degrees] must be a number from 0 to 90, got 120.0.",
    ),
    "unknown weather": (
        ["data", "render", "--weather", "rain"],
        "The flight's weather must be one of clear, hazy, overcast, got 'rain'.",
    ),
    "unknown time": (
        ["data", "render", "--time", "night"],
        "The flight's time of day must be one of morning, noon, evening, got 'night'.",
    ),
    "negative seed": (
        ["data", "render", "--seed", "-1"],
        "A seed must be a whole number from 0 to 4294967295, got -1.",
    ),
    "no frames": (["data", "render", "--frames", "0"], "A flight's frames must be from 1 to 100000, got 0."),
    "too long": (
        ["data", "render", "--frames", "1400"],
        "A flight must be at most 1200 m long, got 1400 frames over 1260 m.",
    ),
    "too long a run": (
        ["run", "--duration", "200"],
        "A rendered flight has at most 1333 frames; an experiment needs 2060 (6 s of warm-up at most",
    ),
    "unknown panel": (
        [*CAMPAIGN, "--flights", "panell", "--out", "o"],
        "There is no flight 'panell': did you mean 'panel', or name default, panel, one of the panel (town2-",
    ),
    "missing bag": ([*CAMPAIGN, "--flights", "a/b.mcap", "--out", "o"], "There is no bag at a/b.mcap"),
    "twice the same": (
        [*CAMPAIGN, "--flights", "default,default", "--out", "o"],
        "Each flight must be named once, got default, default; LABEL=PATH gives a bag another name.",
    ),
    "two bags of one name": (
        [*CAMPAIGN, "--flights", "a/flight.mcap,b/flight.mcap", "--out", "o"],
        "Each flight must be named once, got flight, flight",
    ),
    "no label": (
        [*CAMPAIGN, "--flights", "a b=x.mcap", "--out", "o"],
        "The label of a flight must be 1 to 40 of",
    ),
    "a bag and flights": (
        [*CAMPAIGN, "--flights", "default", "--bag", "x", "--out", "o"],
        "A campaign has one bag or several flights, not both: name the bag as a flight.",
    ),
    "no flights": ([*CAMPAIGN, "--flights", ",", "--out", "o"], "The flights must be names or bags, got ','"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_flight_that_cannot_be(
    case: str, tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    arguments, sentence = BAD[case]

    assert sentence in complaint(arguments)
    assert not (tmp_path / "o" / "runs").exists()


def test_a_corrupt_and_a_short_bag_are_refused_before_anything_is_run(
    tmp_path: Path, flight: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    (tmp_path / "corrupt.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(100))
    with read_bag(flight) as reader:
        write_bag(tmp_path / "short.mcap", [reader.frame(0)], reader.stamps_ns[:1])

    assert "corrupt.mcap cannot be read" in complaint(
        [*CAMPAIGN, "--flights", "default,corrupt.mcap", "--out", "o"]
    )
    assert "holds 1 frames" in complaint([*CAMPAIGN, "--flights", "default,short.mcap", "--out", "o"])
    assert count_runs(tmp_path / "o") is None


def test_a_cache_that_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, complaint: Callable[[Sequence[str]], str]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "file"))

    assert "set SUNSET_CACHE_DIR to another folder" in complaint(["data", "render", "--frames", "1"])


@pytest.fixture(scope="module")
def bag(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("flight") / "mine"
    with read_bag(flight) as reader:
        write_bag(path, map(reader.frame, range(100, 100 + FRAMES)), reader.stamps_ns[:FRAMES])
    return path


@pytest.mark.thorough
def test_a_campaign_crosses_scenarios_with_flights(
    tmp_path: Path, bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = BenchSpec(
        suite="nofault",
        managers=("none",),
        flights=("default", f"part={bag}"),
        references=False,
        score=False,
        repetitions=1,
        settings=Settings(timing=Timing(duration_s=1.0)),
    )
    out = tmp_path / "out"
    assert bench(spec, out, jobs=1) == 2
    assert bench(spec, out, jobs=1) == 0
    assert count_runs(out) == (2, 2)

    plan = read_plan(out)
    assert plan.flights == spec.flights
    (name,) = plan.flight_facts
    runs = {run.flight.name: run for run in load_results(out)}
    assert runs.keys() == {"default", "part"} == {"default", name}
    assert {run.folder.name for run in runs.values()} == {"seed-1-default", "seed-1-part"}
    assert {run.model for run in runs.values()} == {"lite"}
    record = read_run(runs["part"].folder)
    assert record.bag_frames == FRAMES
    assert record.entropy_threshold == plan.flight_facts["part"].entropy_threshold
    assert read_run(runs["default"].folder).entropy_threshold != record.entropy_threshold

    assert main(["report", str(out), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert {(row["flight"], row["runs"]) for row in rows} == {("default", 1), ("part", 1)}
    assert {row["system"].split(" [flight ")[1] for row in rows} == {"default]", "part]"}

    assert main(["bundle", str(out), "--out", str(tmp_path / "results.zip")]) == 0
    assert main(["verify", str(tmp_path / "results.zip"), "--run-again", "0"]) == 0


@pytest.mark.thorough
def test_without_the_renderer_flights_are_flown_that_were_rendered_elsewhere(
    flight: Path, tmp_path: Path
) -> None:
    (tmp_path / "embreex.py").write_text("raise ModuleNotFoundError", "utf-8")  # as where it has no wheel

    def run(**settings: str) -> subprocess.CompletedProcess[str]:
        words = [sys.executable, "-m", "sunset", "run", "--duration", "1", "--out", str(tmp_path / "run")]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)} | settings
        return subprocess.run(words, env=environment, capture_output=True, text=True, check=False)

    assert flight.is_dir()
    assert run().returncode == 0
    refused = run(SUNSET_CACHE_DIR=str(tmp_path / "cache"))
    assert refused.returncode == 2
    (sentence,) = (line for line in refused.stderr.splitlines() if line.startswith("sunset: "))
    assert "needs embreex, which is not installed" in sentence
    assert "copy the cache folder" in sentence

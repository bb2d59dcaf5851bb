"""Each managing system of the gallery, behind the walls, on six scenarios, where its libraries are installed."""

import re
from importlib.util import find_spec
from pathlib import Path

import pytest

import sunset
from sunset.evaluation.results import RunRow

ROOT = Path(__file__).parents[2]
HERE = ROOT / "examples" / "gallery"
FAULTS = (
    "camera_driver_issue",
    "gpu_failure",
    "image_degradation",
    "image_shift",
    "depth_degradation",
    "autofocus_needed",
)
COMMANDS = re.findall(r"`sunset run --manager '?(.+?)'?`", (HERE / "README.md").read_text(encoding="utf-8"))
MEMBERS = {re.findall(r"(\w+)\.py", command)[0]: command for command in COMMANDS}
MODELS = [name for name in MEMBERS if name.startswith("language_model")]
OTHERS = [name for name in MEMBERS if name not in MODELS]


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[RunRow]]:
    """Return the runs of each member."""
    for library in ("clingo", "mabwiser", "pgmpy", "py_trees", "stormpy", "up_pyperplan"):
        if find_spec(library) is None:
            pytest.skip("needs the libraries of examples/gallery/requirements.txt")
    results = sunset.bench(
        "single",
        {name: command.replace("examples/", f"{ROOT}/examples/") for name, command in MEMBERS.items()},
        out=tmp_path_factory.mktemp("gallery") / "runs",
        scenarios=[f"single/{fault}" for fault in FAULTS],
        repetitions=1,
        duration=7,
        score=False,
        references=False,
    )
    return {name: [run for run in results.runs if run.manager == name] for name in MEMBERS}


@pytest.mark.parametrize("name", MEMBERS)
def test_a_member_follows_the_rules_to_the_end_of_every_run(name: str, runs: dict[str, list[RunRow]]) -> None:
    assert [(run.scenario, run.failed, run.reason) for run in runs[name] if run.failed or not run.valid] == []
    assert len(runs[name]) == len(FAULTS)


@pytest.mark.parametrize("name", OTHERS)
def test_a_member_cures_five_of_the_six_faults(name: str, runs: dict[str, list[RunRow]]) -> None:
    cured = [run.scenario for run in runs[name] if run.metrics["faults_cured"]]
    assert len(cured) >= len(FAULTS) - 1, cured


@pytest.mark.parametrize("name", MODELS)
def test_a_language_model_has_costs(name: str, runs: dict[str, list[RunRow]]) -> None:
    assert all(run.models_asked and run.metrics["tokens_in"] for run in runs[name])


def test_the_page_lists_all_members() -> None:
    scripts = {"learn", "recorder"}
    assert set(MEMBERS) == {file.stem for file in HERE.glob("*.py")} - scripts


def test_members_are_short() -> None:
    lengths = {name: len((HERE / f"{name}.py").read_text(encoding="utf-8").splitlines()) for name in MEMBERS}
    assert {name: length for name, length in lengths.items() if length > 60} == {}

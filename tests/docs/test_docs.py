"""What the documentation shows works as it says."""

import re
import subprocess
import sys
from configparser import ConfigParser
from itertools import pairwise
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.recording import StoredRun
from sunset.scenarios import load_scenario, parse_scenario

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "examples" / "gallery" / "README.md"
PAGES = [ROOT / "README.md", ROOT / "ARTIFACT.md", GALLERY, *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: str, language: str) -> list[str]:
    """Return the fenced blocks of a page in one language."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


def fly(scenario: str, manager: str, folder: Path, duration_s: float = 4.0) -> StoredRun:
    """Run an experiment of four seconds, long enough for what most pages show."""
    settings = Settings(timing=Timing(duration_s=duration_s))
    return run(RunSpec(scenario=load_scenario(scenario), manager=manager, settings=settings), folder)


@pytest.mark.parametrize("page", ["README.md", "docs/managing-systems.md"])
def test_the_managing_system_of_a_page_focuses_the_camera(page: str, flight: Path, tmp_path: Path) -> None:
    del flight
    source, *_ = blocks(page, "python")
    assert len(source.splitlines()) <= 30
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    result = fly("autofocus_needed", f"{tmp_path / 'mine.py'}:Mine", tmp_path / "run")

    (episode,) = [episode for episode in result.metrics.failures if episode.failure == "F5"]
    assert episode.resolved
    assert {str(adaptation) for adaptation in result.metrics.executed} == {
        "set camera.perform_autofocus to true"
    }


def test_the_managing_system_of_the_page_waits_retries_and_tries_the_next_cure(
    flight: Path, tmp_path: Path
) -> None:
    del flight
    _, source, _ = blocks("docs/managing-systems.md", "python")
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    result = fly("memory_leakage+image_shift", f"{tmp_path / 'mine.py'}:Mine", tmp_path / "run", 10.0)

    assert all(episode.resolved for episode in result.metrics.failures)
    adaptations = [str(adaptation) for adaptation in result.metrics.executed]
    assert adaptations[:2] == ["restart sensor_fusion", "redeploy sensor_fusion"]
    assert len(adaptations) <= 6


def test_the_managing_system_of_the_page_that_only_chooses_takes_the_cure_of_the_most_faults(
    flight: Path, tmp_path: Path
) -> None:
    del flight
    *_, source = blocks("docs/managing-systems.md", "python")
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    result = fly("gpu_failure", f"{tmp_path / 'mine.py'}:Mine", tmp_path / "run")

    assert all(episode.resolved for episode in result.metrics.failures)
    assert [str(adaptation) for adaptation in result.metrics.executed] == ["redeploy segmentation"]


@pytest.mark.parametrize("file", sorted((ROOT / "docs" / "programs").iterdir()), ids=lambda file: file.name)
def test_the_page_shows_the_programs_whole_or_links_them(file: Path) -> None:
    page = (ROOT / "docs" / "programs.md").read_text(encoding="utf-8")
    language = {".py": "python", ".sh": "sh", ".cpp": "cpp"}[file.suffix]

    assert f"](programs/{file.name})" in page or file.read_text(encoding="utf-8") in blocks(
        "docs/programs.md", language
    )


def test_the_baseline_makes_a_fault_that_heals_last_3_s_longer(flight: Path, tmp_path: Path) -> None:
    del flight
    repaired, left = (
        fly("transient/hardware_disconnect-for-2-s", manager, tmp_path / manager, 12.0)
        for manager in ("baseline", "none")
    )

    ends = [next(one.ended for one in run.metrics.failures if one.injected) for run in (repaired, left)]
    assert ends == [pytest.approx(10.08, abs=0.01), pytest.approx(7.08, abs=0.01)]
    assert "it would have healed by itself at 7.00 s, 3.08 s before F1 was over" in str(repaired)


def test_the_new_node_of_the_page_does_what_the_page_says(tmp_path: Path) -> None:
    node, trial = blocks("docs/adding-a-node.md", "python")
    (expected,) = blocks("docs/adding-a-node.md", "text")
    (tmp_path / "brightness.py").write_text(node, encoding="utf-8")
    (tmp_path / "try_it.py").write_text(trial, encoding="utf-8")

    done = subprocess.run(
        [sys.executable, "try_it.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.stderr == ""
    assert done.stdout == expected


def test_the_program_of_the_page_reads_a_record(flight: Path, tmp_path: Path) -> None:
    del flight
    fly("gpu_failure", "baseline", tmp_path / "run")
    (program,) = blocks("docs/metrics.md", "python")

    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.stderr == ""
    assert re.fullmatch(r"(\d+ /managed_subsystem/\w+ \w+\n)+", done.stdout)
    assert " /managed_subsystem/segmentation redeploy\n" in done.stdout


@pytest.mark.parametrize("number", [0, 1])
def test_the_scenarios_of_the_page_load(number: int) -> None:
    assert parse_scenario(blocks("docs/scenarios.md", "yaml")[number], "page.yaml").faults


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_of_the_pages_are_understood(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = page.read_text(encoding="utf-8")
    for verb in sorted(set(re.findall(r"(?:^|`)sunset ([a-z]+)", text, flags=re.MULTILINE))):
        with pytest.raises(SystemExit) as way_out:
            main([verb, "--help"])
        assert way_out.value.code == 0
        capsys.readouterr()


def test_packages_are_listed_in_the_order_in_which_they_import() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("## Packages")[2].partition("\n## ")[0]
    listed = [
        re.findall(r"`(\w+)`", line.split("|")[1]) for line in table.splitlines() if line.startswith("| `")
    ]
    contracts = ConfigParser()
    contracts.read(ROOT / ".importlinter")
    layers = contracts["importlinter:contract:layers"]["layers"].split("\n")
    order = {name: number for number, layer in enumerate(layers) for name in layer.replace("|", " ").split()}

    assert sorted(name for row in listed for name in row) == sorted(order)
    assert all(
        order[above] <= order[below] for one, other in pairwise(listed) for above in one for below in other
    )


def test_the_distribution_of_the_page_is_the_references() -> None:
    (block,) = blocks("docs/models.md", "toml")

    assert block in (ROOT / "models" / "reference" / "pyproject.toml").read_text(encoding="utf-8")

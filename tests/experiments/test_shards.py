"""Parts of a campaign: none is run twice, none is left out, and together they are the whole."""

import json
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import pytest
from tests.experiments.campaigns import RUNS, bench_command, content_of

import sunset
from sunset.errors import InvalidInputError, OutputError
from sunset.evaluation.report import FORMATS, render_runs
from sunset.experiments import BenchSpec, Shard, count_runs, plan
from sunset.experiments.bench import locked_campaign


@pytest.mark.parametrize(
    "text", ["0/4", "5/4", "x/y", "1/0", "4", "", "1/2/3", "-1/2", " 1/2", "1/\uff12", 1, None]
)
def test_what_is_not_a_shard_is_told(text: object) -> None:
    with pytest.raises(
        InvalidInputError, match="A shard must be I/N, the I-th of N parts, from 1/N to N/N, got"
    ):
        Shard.parse(text)


@pytest.mark.parametrize("count", [1, 2, 7, 117])
def test_the_shards_of_a_campaign_are_its_runs_in_order(count: int) -> None:
    runs = plan(BenchSpec(repetitions=1))
    shards = [Shard.parse(f"{number}/{count}").of(runs) for number in range(1, count + 1)]

    assert [one for shard in shards for one in shard] == list(runs)
    assert len({*map(len, shards)}) <= 2
    assert all(abs(len(one) - len(other)) <= 1 for one, other in pairwise(shards))


def test_a_campaign_has_not_more_shards_than_runs() -> None:
    with pytest.raises(InvalidInputError, match=r"A campaign of 2 runs cannot have 3 shards\."):
        Shard(1, 3).of("ab")


def test_shards_share_a_folder_and_nobody_else_does(tmp_path: Path) -> None:
    busy = "is being run by another process"
    with locked_campaign(tmp_path, Shard(1, 2)):
        with locked_campaign(tmp_path, Shard(2, 2)):
            pass
        with pytest.raises(OutputError, match=busy), locked_campaign(tmp_path, Shard(1, 2)):
            pass
        with pytest.raises(OutputError, match=busy), locked_campaign(tmp_path):
            pass
    with (
        locked_campaign(tmp_path),
        pytest.raises(OutputError, match=busy),
        locked_campaign(tmp_path, Shard(2, 2)),
    ):
        pass


@pytest.mark.thorough
@pytest.mark.xdist_group("campaign")
def test_shards_are_together_the_whole(undisturbed: Path, tmp_path: Path) -> None:
    apart, whole = tmp_path / "apart", tmp_path / "whole"
    shards = [apart / "b", apart / "a"]  # the order of folders decides nothing
    for number, folder in enumerate(shards, 1):
        done = subprocess.run(
            bench_command(folder, "--jobs", "2", "--shard", f"{number}/2"),
            check=True,
            capture_output=True,
            text=True,
        )
        assert f"{RUNS // 2} runs done, 0 were there already. Part {number} of 2 is done." in done.stderr
        assert f"is not finished: {RUNS // 2} of {RUNS} runs are there." in done.stdout

    for form in FORMATS:
        assert sunset.report(apart, form) == sunset.report(undisturbed, form)
    assert _without_folders(apart) == _without_folders(undisturbed)
    assert count_runs(apart) == (RUNS, RUNS)

    for folder in shards:
        shutil.copytree(folder, whole, dirs_exist_ok=True)
    assert content_of(whole) == content_of(undisturbed)
    again = subprocess.run(bench_command(whole), check=True, capture_output=True, text=True)
    assert f"0 runs done, {RUNS} were there already." in again.stderr


def _without_folders(folder: Path) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = json.loads(render_runs(folder, "json"))["runs"]
    return [{name: value for name, value in row.items() if name != "folder"} for row in rows]

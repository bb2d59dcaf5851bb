"""What is looked up is what is computed: records of random runs are the same with and without the cache."""

from dataclasses import replace
from pathlib import Path

import pytest
from tests.experiments.test_suites import beginning

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.managing import MANAGERS
from sunset.scenarios import suite, suite_names
from sunset_ros.seeding import generator

DURATION_S = 2.0
TIMING = Timing(duration_s=DURATION_S, warm_up_s=0.4, period_s=0.2)


def drawn(number: int) -> RunSpec:
    rng = generator(number, "lookup")
    scenarios = suite(str(rng.choice(suite_names())))
    return RunSpec(
        scenario=beginning(scenarios[int(rng.integers(len(scenarios)))], DURATION_S),
        manager=str(rng.choice(sorted(set(MANAGERS)))),
        seed=int(rng.integers(1000)),
        settings=Settings(timing=TIMING),
    )


def check(number: int, folder: Path) -> None:
    spec = drawn(number)
    computed = replace(spec, settings=replace(spec.settings, cache=False))
    expected = run(computed, folder / "computed")
    digests = [run(spec, folder / name).digest for name in ("perhaps-computed", "looked-up")]
    assert digests == [expected.digest, expected.digest], (spec.scenario.name, spec.manager)


@pytest.mark.parametrize("number", range(20))
def test_a_record_is_the_same_with_and_without_the_cache(number: int, tmp_path: Path) -> None:
    check(number, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("number", range(20, 300))
def test_more_records_are_the_same_with_and_without_the_cache(number: int, tmp_path: Path) -> None:
    check(number, tmp_path)

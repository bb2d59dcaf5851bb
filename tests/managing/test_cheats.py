"""Whoever masks, prevents blindly, silences, toggles or boasts scores under the baseline, and the columns name why."""

from pathlib import Path

import pytest
from tests.managing import cheats

import sunset
from sunset.evaluation.summary import summarise

SCENARIOS = ("gpu_failure", "image_shift", "depth_degradation")
DURATION_S = 7.0


@pytest.mark.thorough
def test_every_cheat_scores_under_the_baseline_and_is_seen_through(tmp_path: Path) -> None:
    names = [cheat.__name__ for cheat in cheats.CHEATS]
    assert len(names) >= 14
    results = sunset.bench(
        "single",
        {"baseline": "baseline"} | {name: f"{cheats.__file__}:{name}" for name in names},
        out=tmp_path / "out",
        scenarios=SCENARIOS,
        repetitions=1,
        duration=DURATION_S,
        references=False,
    )
    assert all(run.valid for run in results.runs)
    (table,) = results.scores
    scores = {row.manager: row.score.mean for row in table.rows if row.score is not None}
    assert scores["none"] == 0.0
    assert scores["oracle"] == 1.0
    assert scores["baseline"] > 0.3
    for name in names:
        assert scores[name] < scores["baseline"] - 0.1, name

    found = {row.system.split()[0]: row for row in summarise(results.runs)}
    masked = found["DepthWhenUnsure"].estimates["masked_s"]
    assert masked is not None
    assert masked.mean > 1.0
    for name in sorted(
        {*names} - {"DepthWhenUnsure", "SilenceWhenUnsure", "OnlyTheCamera", "NameEveryFault"}
    ):
        needless = found[name].estimates["needless"]
        assert needless is not None, name
        assert needless.mean >= 1.0, name
    brier, first = (found["NameEveryFault"].estimates[name] for name in ("brier", "faults_top1"))
    assert brier is not None
    assert brier.mean > 0.8
    assert first is not None
    assert first.mean == 0

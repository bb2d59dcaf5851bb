"""The rules of the paper's evaluation script as they are described, written anew: logs on disk → the five figures.

Nothing of the package is used, so that both can be compared. One function reads with the standard library's `csv`,
the other one with pandas, which guesses the types of columns.
"""

import csv
import itertools
import statistics
from collections.abc import Iterable
from pathlib import Path
from typing import Any

Figures = dict[str, tuple[float, float] | None]

NEEDING = ("hardware_disconnect", "memory_leakage", "gpu_failure")
WALL_NS = 10**18


def spread(values: list[float]) -> tuple[float, float] | None:
    return (statistics.mean(values), statistics.pstdev(values)) if values else None


def evaluate_with_csv(files: Iterable[Path]) -> Figures:
    shares, reactions, unneeded, downtimes, ious = [], [], [], [], []
    for file in files:
        with file.open(newline="") as text:
            rows = list(csv.DictReader(text))[:-4]
        assert [int(row["timestamp"]) for row in rows] == sorted(int(row["timestamp"]) for row in rows)
        last = max((at for at, row in enumerate(rows) if row["source"] != "/evaluator_log"), default=None)
        if last is not None:
            rows = rows[: last + 11]
        started = [row for row in rows if row["source"] == "planning" and row["strategy_status"] == "1"]
        needed = [
            row for row in rows if row["source"] == "scenario_executor" and row["gt_failure_name"] in NEEDING
        ]
        unneeded.append(float(sum("redeploy" in row["strategy_name"] for row in started) - len(needed)))
        frames = [row for row in rows if row["source"] == "/evaluator_log"]
        analyzer = [row for row in rows if row["source"] == "analyzer"]
        if len(frames) < 10 or not analyzer:
            continue
        assert all(0 < int(row["timestamp"]) < WALL_NS for row in rows)
        open_since: dict[str, int] = {}
        successes = 0
        for row in analyzer:
            rule, at = row["rule_name"], int(row["timestamp"])
            if row["strategy_name"] == "":
                assert row["strategy_status"] == "0"
                assert rule not in open_since
                open_since[rule] = at
            else:
                assert row["strategy_status"] in {"3", "5"}
                successes += 1
                reactions.append((at - open_since.pop(rule)) / 1e9)
        shares.append(successes / len(started))
        times = [int(row["timestamp"]) for row in frames]
        downtimes.append(sum(b - a for a, b in itertools.pairwise(times) if b - a > 2e8) / 1e9)
        ious += [float(row["iou"]) for row in frames]
    values = (shares, reactions, unneeded, downtimes, ious)
    return dict(zip(("f/a", "t_react", "#redeploy_u", "t_down", "IoU"), map(spread, values), strict=True))


def evaluate_with_pandas(files: Iterable[Path], pd: Any) -> Figures:
    shares, reactions, unneeded, downtimes = [], [], [], []
    pooled = []
    for file in files:
        log = pd.read_csv(file)
        assert log["timestamp"].is_monotonic_increasing
        log = log.iloc[:-4]
        others = log.index[log["source"] != "/evaluator_log"]
        if len(others):
            log = log.loc[: others[-1] + 10]
        plans = log[(log["source"] == "planning") & (log["strategy_status"] == 1)]
        needed = (log["source"] == "scenario_executor") & log["gt_failure_name"].isin(NEEDING)
        unneeded.append(
            float(plans["strategy_name"].astype(str).str.contains("redeploy").sum() - needed.sum())
        )
        frames = log[log["source"] == "/evaluator_log"]
        analyzer = log[log["source"] == "analyzer"]
        if len(frames) < 10 or analyzer.empty:
            continue
        assert ((log["timestamp"] > 0) & (log["timestamp"] < WALL_NS)).all()
        succeeded = analyzer["strategy_status"].isin([3, 5])
        assert (analyzer["strategy_name"].isna() == (analyzer["strategy_status"] == 0)).all()
        for _, rule in analyzer.groupby("rule_name"):
            triggers = rule[rule["strategy_name"].isna()]["timestamp"].to_list()
            outcomes = rule[rule["strategy_status"].isin([3, 5])]["timestamp"].to_list()
            assert 0 <= len(triggers) - len(outcomes) <= 1
            assert rule["strategy_name"].isna().to_list() == [at % 2 == 0 for at in range(len(rule))]
            reactions += [(end - begin) / 1e9 for begin, end in zip(triggers, outcomes, strict=False)]
        shares.append(float(succeeded.sum() / len(plans)))
        gaps = frames["timestamp"].diff()
        downtimes.append(float(gaps[gaps > 2e8].sum() / 1e9))
        pooled.append(frames["iou"])
    ious = [float(iou) for iou in pd.concat(pooled)] if pooled else []
    values = (shares, reactions, unneeded, downtimes, ious)
    return dict(zip(("f/a", "t_react", "#redeploy_u", "t_down", "IoU"), map(spread, values), strict=True))

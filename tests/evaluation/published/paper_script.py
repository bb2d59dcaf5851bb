"""The rules of the paper's evaluation script as they are described, written anew: logs on disk → the five figures.

Nothing of the package is used, so that both can be compared.
"""

import csv
import itertools
import statistics
from collections.abc import Iterable
from pathlib import Path

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

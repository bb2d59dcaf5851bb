"""Processes that are killed during a live run: the run ends, with a record or a sentence, and no orphan."""

import json
import os
import signal
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest
from tests.live.systems import (
    ESSENTIAL,
    MANAGED,
    PATIENCE_S,
    Flow,
    Tool,
    benching,
    children,
    domain_of,
    eventually,
    exists,
    flying,
    fork_server,
)

from sunset.recording import read_timeline

pytestmark = [pytest.mark.xdist_group("processes"), pytest.mark.thorough]

TURNS = (("image_enhancement", "segmentation"), ("sensor_fusion",), ("camera", "depth"))
"""Those whose outages can be told apart are done away with at once, to save time."""

SILENT = {"image_enhancement"}
"""It is inactive, so that nobody misses it."""

LONGEST_S = 60.0
"""Time enough for all that is done, even on a busy computer."""


def are_new(pid: int, before: Mapping[str, int], nodes: Iterable[str]) -> bool:
    """Wait until nodes of a run have other processes than before."""

    def new() -> bool:
        now = children(pid)
        return all(now.get(node, before[node]) != before[node] for node in nodes)

    return eventually(new)


def test_the_baseline_redeploys_whatever_does_not_send_any_more(tmp_path: Path) -> None:
    out = tmp_path / "run"
    with flying("nofault", "baseline", LONGEST_S, out) as process:
        first = children(process.pid)
        tool = Tool(domain_of(process.pid))
        flow = Flow(tool)
        try:
            assert flow.lasts()
            server = fork_server(process.pid)
            os.kill(server, signal.SIGKILL)  # nodes can be redeployed without it
            for nodes in TURNS:
                before = first | children(process.pid)
                for node in nodes:
                    os.kill(before[node], signal.SIGKILL)
                assert are_new(process.pid, before, set(nodes) - SILENT)
                assert flow.lasts()
            _, complaint = process.communicate(timeout=LONGEST_S + PATIENCE_S)
        finally:
            tool.node.context.try_shutdown()
    assert process.returncode == 0, complaint
    assert not any(exists(pid) for pid in first.values())
    redeployed = {
        one.node for one in read_timeline(out).commands if one.kind == "redeploy" and one.successful
    }
    assert redeployed == {f"/managed_subsystem/{node}" for node in set(MANAGED) - SILENT}


@pytest.mark.parametrize("node", ESSENTIAL)
def test_a_run_ends_with_what_there_is_no_experiment_without(tmp_path: Path, node: str) -> None:
    with flying("nofault", "none", LONGEST_S, tmp_path / "run") as process:
        os.kill(children(process.pid)[node], signal.SIGKILL)
        _, complaint = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert f"The process of {node}, which the experiment needs, ended by signal 9 (SIGKILL)" in complaint
    assert list(tmp_path.iterdir()) == []


def test_a_campaign_that_is_killed_keeps_what_it_finished(tmp_path: Path) -> None:
    with benching(tmp_path) as process:
        first = children(process.pid)
        assert eventually(lambda: len(list(tmp_path.rglob("run.json"))) == 1)
        assert eventually(lambda: not {*children(process.pid).values()} & {*first.values()})
        assert eventually(lambda: set(children(process.pid)) >= set(MANAGED))
        second = children(process.pid)
        process.kill()
        assert eventually(lambda: not any(exists(pid) for pid in second.values()))
    (finished,) = tmp_path.rglob("run.json")
    assert json.loads(finished.read_text(encoding="utf-8"))["seed"] == 1
    assert read_timeline(finished.parent).frames

"""Faults that no catalogue lists: each shows as one of the known failures, and its cures bring back what was before."""

from pathlib import Path
from typing import Final

import pytest
from tests.experiments.test_cure_matrix import ADAPTATIONS, ADAPTERS, fly, settled_iou, timing_of

from sunset.errors import ExtensionError
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.nodes import AdaptiveNode
from sunset.recording import StoredRun, read_messages
from sunset.scenarios import Scenario, ScenarioFault, load_scenario
from sunset.system import Adaptation, Fault, FaultKind, current_system, extended_system, unlisted
from sunset.wild.nodes import NODE_CLASSES
from sunset_ros import Context
from sunset_ros.rmw.sim import Simulation

ONSET_S: Final = 1.5
CAUSES: Final = {fault.name: fault for fault in unlisted().faults}
CURES: Final = [(fault.name, step) for fault in CAUSES.values() for (step,) in fault.cures]


def healthy_iou(folder: Path, fault: Fault, step: Adaptation) -> float:
    """Return what a cure can give at best: what works around a fault lasts, and has its price."""
    manager = adapter(step) if fault.kind is FaultKind.EXTERNAL else "none"
    return settled_iou(fly(folder, manager, timing_of(step)))


def adapter(step: Adaptation) -> str:
    return f"{ADAPTERS}:Adapt_{ADAPTATIONS.index(step):02d}"


def shown(result: StoredRun) -> set[str]:
    return {episode.failure for episode in result.metrics.failures}


@pytest.mark.parametrize("name", CAUSES)
def test_a_cause_shows_and_harms_until_it_is_cured(name: str, flight: Path, tmp_path: Path) -> None:
    del flight
    fault = CAUSES[name]
    (step,) = fault.cures[0]
    timing = timing_of(step)
    healthy = healthy_iou(tmp_path / "healthy", fault, step)
    ill = fly(tmp_path / "ill", "none", timing, name)
    assert fault.failure in shown(ill)
    assert any(episode.ended is None for episode in ill.metrics.failures) or settled_iou(ill) < 0.85 * healthy
    assert_cured(fly(tmp_path / "treated", adapter(step), timing, name), healthy)


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "step"), CURES, ids=str)
def test_every_listed_cure_works(name: str, step: Adaptation, flight: Path, tmp_path: Path) -> None:
    del flight
    healthy = healthy_iou(tmp_path / "healthy", CAUSES[name], step)
    assert_cured(fly(tmp_path / "treated", adapter(step), timing_of(step), name), healthy)


def assert_cured(treated: StoredRun, healthy: float) -> None:
    assert all(episode.ended is not None for episode in treated.metrics.failures)
    assert settled_iou(treated) >= 0.85 * healthy
    assert treated.metrics.outcomes[0].fate == "cured"


def fly_later(folder: Path, fault: str) -> StoredRun:
    scenario = Scenario("later", faults=(ScenarioFault(fault, at=ONSET_S),))
    settings = Settings(timing=Timing(duration_s=3.0, warm_up_s=0.5))
    return run(RunSpec(scenario=scenario, manager="none", settings=settings), folder)


def seen_before(folder: Path, fault: str) -> list[tuple[int, str, str]]:
    """Return what is published until a fault comes, but for what only the experiment reads."""
    end_ns = (fly_later(folder, fault).record.start_ns or 0) + round(ONSET_S * 1e9)
    return [
        (one.time_ns, one.topic, repr(one.message))
        for one in read_messages(folder)
        if one.time_ns < end_ns and not one.topic.startswith("/experiment/")
    ]


@pytest.mark.parametrize(
    "fault", ["overexposure", "lossy_link", "short_buffer", "hot_processor", "idle_input"]
)
def test_nothing_tells_what_is_going_to_come(fault: str, flight: Path, tmp_path: Path) -> None:
    del flight
    expected = seen_before(tmp_path / "listed", "gpu_failure")
    assert len(expected) > 100
    assert seen_before(tmp_path / "unlisted", fault) == expected


def test_only_the_experiments_messages_name_a_cause(flight: Path, tmp_path: Path) -> None:
    del flight
    fly_later(tmp_path / "run", "overexposure")
    naming = {one.topic for one in read_messages(tmp_path / "run") if "overexposure" in repr(one.message)}
    assert naming == {"/experiment/injections", "/experiment/parameter_events"}


def test_nodes_list_the_parameters_that_the_ordinary_ones_have() -> None:
    def parameters(node_class: type[AdaptiveNode]) -> list[str]:
        context = Context()
        context.init([], middleware=Simulation(seed=1).create_process("node"))
        return list(node_class(context=context).list_parameters([], 0).names)

    for name, node_class in NODE_CLASSES.items():
        assert parameters(node_class) == parameters(current_system().node_class(name))


def test_an_extensions_own_class_for_a_node_cannot_have_them(tmp_path: Path) -> None:
    (extension := tmp_path / "mine.py").write_text(
        "from sunset.nodes import Camera\nfrom sunset.system import Extension\n"
        "class Mine(Camera): ...\nEXTENSION = Extension(node_classes={'camera': Mine})\n"
    )
    with extended_system([extension]):
        spec = RunSpec(scenario=load_scenario("lossy_link"))
        with pytest.raises(ExtensionError, match=r"mine.py has a class for the node camera, which a run"):
            run(spec, tmp_path / "run")

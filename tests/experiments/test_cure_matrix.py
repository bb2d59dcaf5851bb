"""Every fault with every adaptation, end to end: exactly what the catalogue lists cures."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.recording import StoredRun
from sunset.scenarios import Scenario, ScenarioFault
from sunset.system import Adaptation, AdaptationKind, current_system, full_name

ADAPTATIONS = current_system().adaptations
FAULTS = current_system().faults

ADAPTERS = Path(__file__).with_name("adapters.py")
REDEPLOYED = Timing(duration_s=6.6, warm_up_s=0.5, period_s=0.2)
"""Long enough for the longest redeploy (4 s) and for what follows it to settle."""
CHANGED = Timing(duration_s=3.6, warm_up_s=0.5, period_s=0.2)
"""The same for what takes no redeploy, a second at most."""

LAST_S = 1.0
"""The figures at the end are compared: adaptations are over, and their effects have settled."""


RGB_ONLY = FAULTS["depth_degradation"].cures[0][0]


def timing_of(*adaptations: Adaptation) -> Timing:
    """Return how long it takes to see what adaptations do."""
    kinds = {adaptation.kind for adaptation in adaptations}
    return REDEPLOYED if AdaptationKind.REDEPLOY in kinds else CHANGED


def fly(folder: Path, manager: str, timing: Timing, *faults: str) -> StoredRun:
    scenario = Scenario(
        name="+".join(faults) or "nofault", faults=tuple(ScenarioFault(name) for name in faults)
    )
    return run(RunSpec(scenario=scenario, manager=manager, seed=3, settings=Settings(timing=timing)), folder)


def is_late(result: StoredRun, times: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Return which times are in the last second of a run."""
    end = result.record.duration_s
    return (times >= end - LAST_S) & (times < end)


def settled_iou(result: StoredRun) -> float:
    frames = result.timeline.frames
    late = frames.iou[is_late(result, frames.times)]
    return float(late.mean()) if late.size else 0.0


def keeps_sending(result: StoredRun) -> bool:
    """Whether camera, fusion and segmentation send at the expected rate to the end."""
    expected = LAST_S / result.record.period_s
    counts = [
        np.count_nonzero(is_late(result, times))
        for topic in ("rgb_camera", "sensors_fused", "segmentation")
        for times in [result.timeline.message_times.get(full_name(topic), np.empty(0))]
    ]
    return all(count >= 0.9 * expected for count in counts)


def is_cured(result: StoredRun, healthy_iou: float) -> bool:
    """Whether no symptom is left and the segmentation is about as good as without the fault."""
    return (
        keeps_sending(result)
        and all(episode.ended is not None for episode in result.metrics.failures)
        and settled_iou(result) >= 0.85 * healthy_iou
    )


@cache
def _listed() -> dict[str, list[tuple[Adaptation, ...]]]:
    return {fault.name: list(fault.cures) for fault in FAULTS.values()}


@pytest.fixture(scope="module")
def healthy_ious(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Timing], float]:
    """Return what a cure of a fault can give at best."""
    del flight

    @cache
    def healthy_iou(manager: str, timing: Timing) -> float:
        return settled_iou(fly(tmp_path_factory.mktemp("healthy") / "run", manager, timing))

    # without depth images nothing can be better than the network for colour images alone
    rgb_only = f"{ADAPTERS}:Adapt_{ADAPTATIONS.index(RGB_ONLY):02d}"
    return lambda fault, timing: healthy_iou(rgb_only if fault == "depth_degradation" else "none", timing)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_harms_until_it_is_cured(
    fault: str, healthy_ious: Callable[[str, Timing], float], tmp_path: Path
) -> None:
    cure = FAULTS[fault].cures[0]
    manager = "CureImageDegradation" if len(cure) > 1 else f"Adapt_{ADAPTATIONS.index(cure[0]):02d}"
    timing = timing_of(*cure)
    healthy = healthy_ious(fault, timing)

    assert not is_cured(fly(tmp_path / "ill", "none", timing, fault), healthy)
    assert is_cured(fly(tmp_path / "treated", f"{ADAPTERS}:{manager}", timing, fault), healthy)


@pytest.mark.thorough
@pytest.mark.parametrize("fault", FAULTS)
def test_exactly_the_listed_adaptations_cure(
    fault: str, healthy_ious: Callable[[str, Timing], float], tmp_path: Path
) -> None:
    for timing in (REDEPLOYED, CHANGED):
        ill = fly(tmp_path / f"ill for {timing.duration_s} s", "none", timing, fault)
        no_effect = "the fault has no effect, so nothing can be said of its cures"
        assert not is_cured(ill, healthy_ious(fault, timing)), no_effect

    cures = []
    for index, adaptation in enumerate(ADAPTATIONS):
        timing = timing_of(adaptation)
        treated = fly(tmp_path / f"{index}", f"{ADAPTERS}:Adapt_{index:02d}", timing, fault)
        if is_cured(treated, healthy_ious(fault, timing)):
            cures.append(str(adaptation))

    assert sorted(cures) == sorted(str(cure[0]) for cure in _listed()[fault] if len(cure) == 1)

"""The initial parameters of an experiment's nodes."""

from typing import cast

from sunset.experiments.resources import Resources
from sunset.experiments.spec import RunSpec
from sunset.managing import ORACLE, KnownFault, KnownScenario
from sunset.system import BAG_PLAYER, Value, current_system
from sunset_ros.seeding import drawn_seed, generator

Parameters = dict[str, Value]


def manager_parameters(spec: RunSpec, resources: Resources) -> Parameters:
    """Return the parameters of the managing system, on any middleware."""
    card = resources.model.card
    parameters: Parameters = {
        "entropy_threshold": card.entropy_threshold,
        "sharpness_threshold": card.sharpness_threshold,
        "manager_seed": drawn_seed(spec.seed, "manager"),
        "task": spec.settings.task,
    }
    return parameters | ({"thinking": spec.settings.thinking_s} if spec.settings.thinking_s else {})


def known_scenario(spec: RunSpec, resources: Resources) -> KnownScenario | None:
    """Return the oracle's knowledge of a run; None for every other managing system."""
    if spec.manager != ORACLE:
        return None
    faults = resources.scenario.faults
    causes = {fault.after.fault for fault in faults if fault.after is not None}
    known = [
        KnownFault(
            name=fault.name,
            failure=fault.fault.failure,
            kind=fault.fault.kind,
            cures=fault.fault.cures,
            value=cast("Value", fault.value),
            at=fault.at,
            follows=fault.after is not None,
            until=fault.until,
            rise=fault.profile.rise or 0.0,
            on=fault.profile.on or 0.0,
            off=fault.profile.off or 0.0,
            brings=fault.name in causes,
        )
        for fault in faults
    ]
    return KnownScenario(faults=tuple(known), duration_s=spec.timing.duration_s)


def node_parameters(spec: RunSpec, resources: Resources) -> dict[str, Parameters]:
    """Return the parameters that differ from their defaults, as node → parameter → value."""
    timing, card = spec.timing, resources.model.card
    frames = len(resources.bag)
    starts = frames - timing.frames + 1 if frames >= timing.frames else frames
    start = generator(spec.seed, "flight", "start")
    system = current_system()
    random: dict[str, Parameters] = {
        name: {"seed": drawn_seed(spec.seed, name)}
        for name in system.nodes
        if hasattr(system.node_class(name), "seed")
    }
    return random | {
        "camera": {"sharpness_threshold": card.sharpness_threshold},
        "segmentation": {"model": card.name},
        BAG_PLAYER: {
            "start_frame": int(start.integers(0, starts)),
            "frames": timing.frames,
            "loop": spec.settings.loop,
            "rate": 1 / timing.period_s,
            "phase": float(start.uniform(0, timing.period_s)),
        },
    }

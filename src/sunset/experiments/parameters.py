"""What the nodes of an experiment are told."""

from sunset.experiments.resources import Resources
from sunset.experiments.spec import RunSpec
from sunset.seeding import generator

Parameters = dict[str, bool | int | float | str]


def node_parameters(spec: RunSpec, resources: Resources) -> dict[str, Parameters]:
    """Return node → parameter → value, of those that differ from their defaults, on any middleware."""
    timing, card = spec.settings.timing, resources.model.card
    frames = len(resources.bag)
    starts = frames - timing.frames + 1 if frames >= timing.frames else frames
    start = generator(spec.seed, "flight", "start")
    return {
        "camera": {"sharpness_threshold": card.sharpness_threshold},
        "depth": {"seed": spec.seed},
        "segmentation": {"model": card.name},
        "bag_player": {
            "start_frame": int(start.integers(0, starts)),
            "frames": timing.frames,
            "loop": spec.settings.loop,
            "rate": 1 / timing.period_s,
            "phase": float(start.uniform(0, timing.period_s)),
        },
    }

"""Whether what a run says of itself is what the plan says of it, and what the other runs say."""

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from msgspec import UNSET, Struct
from msgspec.structs import asdict

from sunset.bundling.layout import is_exact
from sunset.experiments import RunSpec, RunTiming, Settings, flight_name, stored_faults
from sunset.managing import MANAGERS
from sunset.metrics import RunMetrics
from sunset.perception import ModelCard
from sunset.recording import RUN_FILE, CampaignPlan, RunRecord, describes_bag
from sunset.scenarios import with_strengths
from sunset.texts import shown

_COMMON: Final = ("bag_frames", "bag_size", "bag_dropped", "frame_size", "compute_s")
"""What is the same in all runs of a campaign on one flight, and stands in no plan."""


def misfits(
    run: RunRecord,
    place: Path,
    expected: Mapping[str, object],
    described: CampaignPlan,
    *,
    manager: str,
) -> Iterator[str]:
    """Yield in what the `run.json` of a run is not that of a run of the plan."""
    for name, value in expected.items():
        yield from _contrasts(name, getattr(run, name), value)
    for name, planned in sorted(described.versions.items()):
        yield from _contrasts(f"version of {name}", run.versions.get(name, UNSET), planned)
    # live, a run has those of the middleware, too
    more = sorted(run.versions.keys() - described.versions.keys()) if run.speed is UNSET else []
    if more:
        yield f"it has the version of {shown(more[0])}, which the plan has not"
    if run.valid != (not run.reason):
        yield f"it is stored as {'' if run.valid else 'in'}valid, with the reason {_shown(run.reason)}"
    if run.manager_failed is not None and manager in MANAGERS and not described.extensions:
        yield f"it is stored as failed, which a run of {manager} never is"
    if run.is_empty and (run.valid or set(run.metrics.values()) != {None}):
        yield "it is stored as failed, and as valid or with figures"
    if not describes_bag(place):
        yield "its metadata.yaml is missing, or is not that of its messages"
    if not is_exact(place / RUN_FILE, run, described.versions) or run.metrics.keys() - RunMetrics.names():
        yield f"its {RUN_FILE} has what no run has, or a key twice"


def unlike_others(runs: Mapping[Path, RunRecord]) -> Iterator[tuple[Path, str]]:
    """Yield where a run is and in what it is not as most runs of its flight are, or as the first one if none are most.

    Args:
        runs: of a campaign, by their folders.
    """
    for flight in dict.fromkeys(run.flight for run in runs.values()):
        alike = {place: run for place, run in runs.items() if run.flight == flight}
        for name in _COMMON:
            values = [getattr(run, name) for run in alike.values()]
            texts = list(map(repr, values))  # lists have no hash
            usual = values[texts.index(max(texts, key=Counter(texts).__getitem__))]
            for place, value in zip(alike, values, strict=True):
                if value != usual:
                    yield place, f"its {name} is {_shown(value)}, and that of the other runs {_shown(usual)}"


def expected_of(spec: RunSpec, described: CampaignPlan, card: ModelCard) -> dict[str, object]:
    """Return what a run's `run.json` must say, by the plan and the model's card."""
    return {
        "scenario": spec.scenario.name,
        "faults": stored_faults(with_strengths(spec.scenario, card.severities, card.name), spec.scenario),
        "suite": spec.suite,
        "manager": spec.manager_name,
        "manager_spec": spec.manager if spec.label else UNSET,
        "seed": spec.seed,
        **expected_of_all(
            spec.manager_name, spec.settings, spec.timing, described, card, flight=flight_name(spec)
        ),
    }


def expected_of_all(
    name: str,
    settings: Settings,
    timing: RunTiming,
    described: CampaignPlan,
    card: ModelCard,
    *,
    flight: str,
) -> dict[str, object]:
    """Return what the `run.json` of every run of a managing system with this timing and flight must say."""
    found = described.flight_facts.get(flight)
    thresholds = card if found is None else found
    live = settings.live
    known = described.manager_checksums.get(name)
    return {
        **({} if known is None else {"manager_checksum": known}),
        "model": card.name,
        "model_checksums": {str(modality): one.digest for modality, one in card.networks.items()},
        "flight": flight,
        "flight_conditions": UNSET if found is None else found.conditions or UNSET,
        "flight_warning": (found is not None and found.warning) or UNSET,
        "entropy_threshold": thresholds.entropy_threshold,
        "sharpness_threshold": thresholds.sharpness_threshold,
        "device": described.device,
        "middleware": described.middleware,
        "bag_checksum": described.bag_checksum if found is None else found.bag_checksum,
        "bag_looped": described.loop,
        "jitter": UNSET if live else timing.jitter,
        "latency_s": UNSET if live else timing.latency_s,
        "speed": described.speed if live else UNSET,
        "warm_up_s": timing.warm_up_s,
        "duration_s": timing.duration_s,
        "period_s": timing.period_s,
        "expected_frames": timing.expected_frames,
        "thinking_s": settings.thinking_s or UNSET,
        "extensions": described.extensions or UNSET,
    }


def _contrasts(name: str, stored: object, planned: object) -> Iterator[str]:
    """Yield in what a stored value is not that of the plan: of as many faults, the parts that are not."""
    if stored == planned:
        return
    if isinstance(stored, list | tuple) and isinstance(planned, list | tuple) and len(stored) == len(planned):
        for place, pair in enumerate(zip(stored, planned, strict=True), 1):
            yield from _contrasts(f"{name}[{place}]", *pair)
    elif isinstance(stored, Struct) and isinstance(planned, Struct):
        for part, value in asdict(stored).items():
            yield from _contrasts(f"{name}.{part}", value, getattr(planned, part))
    else:
        yield f"its {name} is {_shown(stored)}, and that of the plan {_shown(planned)}"


def _shown(value: object) -> str:
    return "nothing" if value is UNSET or value == "" else shown(value)

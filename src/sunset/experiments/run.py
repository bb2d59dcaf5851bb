"""One experiment: from its specification to its record and its metrics."""

import platform
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

import onnxruntime
from msgspec import UNSET, UnsetType

from sunset import __version__
from sunset.errors import ManagerError
from sunset.experiments.manager import isolate, manager_checksum
from sunset.experiments.observer import Observer
from sunset.experiments.resources import Resources, find_resources, own_cache
from sunset.experiments.simulated import fly
from sunset.experiments.spec import RunSpec
from sunset.isolation import Watch
from sunset.managing import checksum, load_manager, manager_sources
from sunset.metrics import RunMetrics, Timeline, score
from sunset.perception import ModelCard
from sunset.recording import RecordWriter, RunRecord, StoredFault, StoredRun, log_of, timeline, told_topics
from sunset.rmw.backends import live_middleware
from sunset.system import current_system


def prepare(spec: RunSpec, *, progress: Callable[[int, int], None] | None = None) -> Resources:
    """Load, check and return everything that the run needs; render the default flight if it is not there.

    Raises:
        SunsetError: as `run`.
    """
    return find_resources(spec, progress=progress)


def run(spec: RunSpec, folder: Path, *, log: bool = False) -> StoredRun:
    """Fly one experiment, write its record to a new folder, and score it.

    The folder appears when the run is complete, under its final name; what is measured is read from the
    recorded messages and from nothing else.

    Args:
        spec: what is flown.
        folder: the record's folder, which must not exist, or be empty.
        log: whether what the managing system logs goes to stderr as well as to the record.

    Raises:
        ManagerError: the managing system could not be loaded, raised, did not return, ended its process, or was
            changed meanwhile.
        ModelError: the model cannot be used.
        DataError: the bag cannot be used.
        OutputError: the record cannot be written.
    """
    return record(spec, folder, log=log)


def record(spec: RunSpec, folder: Path, *, log: bool = False, known: str | None = None) -> StoredRun:
    """Fly one experiment; as `run`, if the managing system's files have a known checksum, any if it is None.

    A simulated one is flown in a process of its own, since the managing system is part of it; what is measured is
    computed here, from what it has recorded.
    """
    spec.load_extensions()
    resources = find_resources(spec)
    with RecordWriter(folder) as writer:
        fly = _fly_live if spec.settings.live else _fly_simulated
        flown = fly(spec, resources, writer, log=log, known=known)
        messages = writer.messages(told_topics())
        observed = timeline(
            messages,
            thresholds=_thresholds(resources.model.card),
            duration_s=spec.settings.timing.duration_s,
            period_s=spec.settings.timing.period_s,
            expected_frames=spec.settings.timing.expected_frames,
        )
        figures = score(observed)
        reasons = [*flown.violations, *filter(None, [flown.shortfall(observed)])]
        outcome = _Outcome(flown.manager_checksum, figures.to_json(), "; ".join(reasons), flown.start_ns)
        flown_run = writer.close(_describe(spec, resources, outcome))
    return StoredRun(folder, flown_run, observed, figures, log_of(messages))


def record_failure(spec: RunSpec, folder: Path, *, manager_checksum: str, reason: str) -> None:
    """Write what stands in the place of a run whose managing system failed: a record without messages or figures.

    Raises:
        OutputError: it cannot be written.
    """
    with RecordWriter(folder) as writer:
        outcome = _Outcome(
            manager_checksum, dict.fromkeys(RunMetrics.names()), reason.rstrip("."), failed=reason
        )
        writer.close(_describe(spec, find_resources(spec), outcome))


@dataclass(frozen=True)
class _Flown:
    """What a record does not hold of the experiment that left it.

    Attributes:
        start_ns: the time of the injection, nanoseconds of the experiment's clock.
        violations: what the managing system did that it must not.
        manager_checksum: of the managing system's files.
        shortfall: says why the computer could not keep up, if it could not; in the simulation it always can.
    """

    start_ns: int
    violations: tuple[str, ...]
    manager_checksum: str
    shortfall: Callable[[Timeline], str] = lambda _: ""


def _fly_simulated(
    spec: RunSpec, resources: Resources, writer: RecordWriter, *, log: bool, known: str | None
) -> _Flown:
    def fly_isolated(watch: Watch) -> dict[str, object]:
        made = watch.call(lambda: load_manager(spec.manager))
        sources = watch.call(lambda: manager_sources(spec.manager, made))
        with _unchanged(spec.manager, lambda: checksum(spec.manager, sources), known) as flown:
            observer = Observer(writer)
            start_ns = fly(spec, own_cache(resources, spec, flown), watch, made, observer, log=log)
        writer.store()
        return {"start_ns": start_ns, "violations": list(observer.violations), "manager_checksum": flown}

    what = f"failed in {spec.scenario.name}, seed {spec.seed}"
    told = isolate(spec.manager, what, fly_isolated, limit_s=spec.settings.manager_limit_s)
    writer.load()
    return _Flown(int(told["start_ns"]), tuple(told["violations"]), str(told["manager_checksum"]))


def _fly_live(
    spec: RunSpec, resources: Resources, writer: RecordWriter, *, log: bool, known: str | None
) -> _Flown:
    from sunset.experiments import live_flight  # noqa: PLC0415  needs an optional extra

    frames = live_flight.FrameCount()
    observer = Observer(writer)
    now = partial(manager_checksum, spec.manager, limit_s=spec.settings.manager_limit_s)
    with _unchanged(spec.manager, now, known) as flown:
        start_ns = live_flight.fly(spec, resources, observer, frames, log=log)
    return _Flown(
        start_ns,
        tuple(observer.violations),
        flown,
        lambda timeline: frames.shortfall(start_ns, timeline, spec.settings.timing),
    )


@contextmanager
def _unchanged(manager: str, checksum_now: Callable[[], str], known: str | None) -> Iterator[str]:
    """Give the checksum of a managing system's files, and make sure that it is the known one, and stays it.

    Raises:
        ManagerError: it is not, or does not.
    """
    first = checksum_now()
    _check_same(manager, first, first if known is None else known)
    yield first
    _check_same(manager, checksum_now(), first)


def _check_same(manager: str, found: str, flown: str) -> None:
    if found != flown:
        raise ManagerError(
            f"The managing system {manager} was changed while it was flown; fly the new one in a new folder."
        )


def _thresholds(card: ModelCard) -> dict[str, float]:
    """Return the thresholds of the model's card, by name; the checksums of extensions stand for theirs."""
    signals = current_system().signals.values()
    return {
        signal.threshold_name: getattr(card, signal.threshold_name) for signal in signals if signal.calibrated
    }


@dataclass(frozen=True)
class _Outcome:
    """What came out of a run.

    Attributes:
        manager_checksum: of the managing system's files.
        metrics: the figures by name.
        reason: why the run does not count; empty if it does.
        start_ns: the time of the injection, nanoseconds of the experiment's clock.
        failed: why the managing system failed, if it did.
    """

    manager_checksum: str
    metrics: Mapping[str, float | None]
    reason: str
    start_ns: int | UnsetType = UNSET
    failed: str | None = None


def _describe(spec: RunSpec, resources: Resources, outcome: _Outcome) -> RunRecord:
    """Return the full specification of a run with its result, as it is stored: no paths, no wall clock."""
    settings, card, bag = spec.settings, resources.model.card, resources.bag
    timing = settings.timing
    return RunRecord(
        scenario=spec.scenario.name,
        faults=[StoredFault(fault.name, fault.value) for fault in spec.scenario.faults],
        suite=spec.suite,
        manager=spec.manager_name,
        manager_spec=spec.manager if spec.label else UNSET,
        manager_checksum=outcome.manager_checksum,
        manager_failed=outcome.failed,
        seed=spec.seed,
        model=card.name,
        model_checksums={str(modality): network.digest for modality, network in card.networks.items()},
        device=resources.segmenter.device,
        middleware=settings.middleware,
        bag_frames=len(bag),
        bag_checksum=resources.bag_checksum,
        bag_looped=settings.loop,
        bag_size=list(bag.recorded_size),
        bag_dropped=sum(bag.dropped.values()),
        frame_size=list(bag.size),
        compute_s=UNSET if settings.live else dict(current_system().compute_s),
        jitter=UNSET if settings.live else timing.jitter,
        latency_s=UNSET if settings.live else timing.latency_s,
        speed=settings.speed if settings.live else UNSET,
        warm_up_s=timing.warm_up_s,
        duration_s=timing.duration_s,
        period_s=timing.period_s,
        expected_frames=timing.expected_frames,
        entropy_threshold=card.entropy_threshold,
        sharpness_threshold=card.sharpness_threshold,
        extensions={one.name: one.checksum for one in spec.extensions} or UNSET,
        versions=versions() | (live_middleware(settings.middleware).versions() if settings.live else {}),
        start_ns=outcome.start_ns,
        metrics=outcome.metrics,
        valid=not outcome.reason,
        reason=outcome.reason,
    )


def versions() -> dict[str, str]:
    """Return the versions of everything that a record's bytes may depend on."""
    return {
        "sunset": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "onnxruntime": onnxruntime.__version__,  # whichever package it came with
        **{name: version(name) for name in ("numpy", "opencv-python-headless", "rosbags")},
    }

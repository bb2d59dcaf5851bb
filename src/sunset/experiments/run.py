"""An experiment: from its specification to its record and its metrics."""

import platform
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

import onnxruntime
from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from sunset.data import cache_folder
from sunset.errors import ExtensionError, ManagerError, MiddlewareError, OutputError
from sunset.experiments.manager import (
    check_name,
    checksum_and_versions,
    isolate,
    manager_checksum,
    manager_spec_of,
)
from sunset.experiments.observer import Observer, shown_topics
from sunset.experiments.resources import Resources, flight_name, prepare, prepare_runs, warn_of_walls
from sunset.experiments.spec import RunSpec, stored_faults
from sunset.experiments.world import World
from sunset.files.sources import package_version
from sunset.harness.confined_manager import manager_process
from sunset.harness.executor import is_at_once
from sunset.managing import EXTERNAL, MANAGERS, is_registered
from sunset.metrics import Evidence, RunMetrics, Timeline, score
from sunset.processes.calls import Watch
from sunset.processes.confinement.walls import WALLS, missing_walls
from sunset.processes.workers import Stages
from sunset.recording import (
    SETTINGS,
    RecordedMessage,
    RecordWriter,
    RunRecord,
    StoredRun,
    log_of,
    story_topics,
    timeline_of,
)
from sunset.scenarios import suite_size
from sunset.system import current_system, degradations_of, short_name, system_with
from sunset.system_interfaces.msg import Command, FaultInjection
from sunset_ros.interfaces.stamps import NS_PER_S, ns_of
from sunset_ros.rmw.backends import live_middleware

_AT_ONCE_S: Final = 0.1
"""Faults that are due when the measured time begins are injected by then."""


def run(spec: RunSpec, folder: Path, *, log: bool = False, preparing: Stages | None = None) -> StoredRun:
    """Run an experiment, write its record to a new folder, and score it.

    The folder appears when the run is complete. A simulated experiment takes place in a process of its own, and the
    managing system in another process; the figures are computed here, from the recorded messages only. If the managing
    system fails, the run goes on without it, and the record says so.

    Args:
        spec: the run.
        folder: the record's folder, which must not exist, or be empty.
        log: whether messages that the managing system logs are printed on stderr, too.
        preparing: called with (stage, frames done, all frames) while the flight is rendered and measured, and before
            the run. Warnings about the flight and about missing walls are logged only if it is given.

    Raises:
        ManagerError: the managing system could not be loaded, or was changed meanwhile.
        ExtensionError: a node of the extended system raised, hung, or ended its process, in the simulation.
        ModelError: the model cannot be used.
        DataError: the bag cannot be used.
        OutputError: the record cannot be written.
    """
    spec.load_extensions()
    (resources,) = prepare_runs([spec], preparing)
    if preparing is not None:
        warn_of_walls([spec])
        preparing("Running", 0, 0)
    return run_prepared(spec, resources, folder, log=log)


def run_prepared(
    spec: RunSpec,
    resources: Resources,
    folder: Path,
    *,
    log: bool = False,
    known: str | None = None,
    wanted: Callable[[str], bool] | None = None,
    played: Sequence[Command] = (),
) -> StoredRun:
    """Run an experiment, as `run`, with its extensions loaded and its resources prepared.

    The managing system's files must have the checksum `known`, if any. `wanted` chooses topics whose images are kept.
    In the simulation, the commands `played` of a record are played back.
    """
    record = describe(spec, resources)
    with RecordWriter(folder, images=spec.settings.images, wanted=wanted) as writer:
        conduct = _run_live if spec.settings.live else partial(_run_simulated, played=played)
        outcome = conduct(spec, resources, writer, log=log, known=known)
        messages = writer.messages(story_topics())
        observed = timeline_of(record, messages)
        figures = score(observed)
        reasons = [*outcome.violations, *_unconfirmed(messages, spec, outcome.start_ns), *_unseen(observed)]
        if outcome.shortfall is not None:
            slowness, lost = outcome.shortfall(observed)
            reasons += filter(None, [slowness])
            record = replace(record, computer_kept_up=not slowness, frames_lost=lost)
        record = replace(
            record,
            manager_checksum=outcome.checksum,
            manager_versions=outcome.imported or UNSET,
            manager_failed=outcome.failure or None,
            evidence=outcome.evidence,
            start_ns=outcome.start_ns,
            metrics=figures.to_json(),
            fault_outcomes=figures.outcomes,
            models_asked=figures.models_asked or UNSET,
            valid=not reasons,
            reason="; ".join(reasons),
        )
        record = writer.close(record)
    return StoredRun(folder, record, observed, figures, log_of(messages))


def _unconfirmed(messages: Sequence[RecordedMessage], spec: RunSpec, start_ns: int) -> Iterator[str]:
    """Yield which faults were refused, except those that the scenario executor reports at the injection."""
    answered = {fault.name for fault in spec.scenario.faults if is_at_once(fault)}
    for recorded in messages:
        message = recorded.message
        if isinstance(message, FaultInjection) and not message.confirmed:
            time_s = (ns_of(message.stamp) - start_ns) / NS_PER_S
            if time_s > _AT_ONCE_S or message.fault not in answered:
                yield f"{short_name(message.node)} did not confirm {message.fault} at {time_s:.2f} s"


def _unseen(observed: Timeline) -> Iterator[str]:
    """Yield which failures could not be seen, since their signals were never reported."""
    system = current_system()
    for failure in system.failures.values():
        if failure.signal and not observed.samples[failure.signal].times.size:
            signal = system.signals[failure.signal]
            yield f"{signal.node} never reported {signal.key}, so that {failure.name} could not be seen"


def record_failure(
    spec: RunSpec, resources: Resources, folder: Path, *, manager_checksum: str, reason: str
) -> None:
    """Write the record of a run whose managing system or extension failed: without messages or figures."""
    failed = replace(
        describe(spec, resources),
        manager_checksum=manager_checksum,
        manager_failed=reason,
        metrics=dict.fromkeys(RunMetrics.names()),
        valid=False,
        reason=reason.rstrip("."),
    )
    with RecordWriter(folder) as writer:
        writer.close(failed)


def run_of_campaign(spec: RunSpec, folder: Path, known: str | None) -> None:
    """Load the extensions and prepare the resources of a run, and do it as `record_run`."""
    spec.load_extensions()
    record_run(spec, prepare(spec), folder, known)


def record_run(spec: RunSpec, resources: Resources, folder: Path, known: str | None) -> None:
    """Do a run; if its managing system, or a node of an extension, fails, write a record of the failure."""
    try:
        run_prepared(spec, resources, folder, known=known)
    except (ManagerError, MiddlewareError, ExtensionError) as error:
        # in the simulation, only code of the user can have misused the middleware
        ours = spec.manager in MANAGERS or (spec.settings.live and isinstance(error, MiddlewareError))
        if ours and not isinstance(error, ExtensionError):
            raise
        record_failure(spec, resources, folder, manager_checksum=known or "", reason=str(error))


def last_run() -> Path:
    """Return the folder of the last run without a folder of its own, in the user's cache; it need not exist yet."""
    return cache_folder() / "last-run"


def keep_last_run(record: Path) -> Path:
    """Move a record to `last_run`, in place of the earlier record, and return its folder."""
    home = last_run()
    try:
        home.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(home, ignore_errors=True)
        shutil.move(record, home)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"The record cannot be kept in {home}: {reason}; '--out DIR' keeps it.") from error
    return home


@dataclass(frozen=True)
class _Outcome:
    """The results of a run besides its messages.

    Live, `shortfall` returns why the computer could not keep up, or nothing, and how many frames it lost.
    """

    start_ns: int
    failure: str
    evidence: Evidence
    violations: Sequence[str]
    checksum: str
    imported: Mapping[str, str]
    shortfall: Callable[[Timeline], tuple[str, int]] | None = None


def _run_simulated(
    spec: RunSpec,
    resources: Resources,
    writer: RecordWriter,
    *,
    log: bool,
    known: str | None,
    played: Sequence[Command],
) -> _Outcome:
    manager_spec = manager_spec_of(spec, resources, log=log)
    with manager_process(manager_spec) as manager:
        check_name(f"/{manager.loaded.node_name}", spec.manager)

        def run_isolated(watch: Watch) -> tuple[int, str, Evidence, Sequence[str]]:
            with system_with(fault.name for fault in spec.scenario.faults):
                observer = Observer(writer, shown=shown_topics(spec.manager), task=spec.settings.task)
                world = World(spec, resources, observer, watch)
                world.let_in(manager)
                if played:
                    world.play_back(played)
                start_ns = world.finish()
            manager.process.kill()
            writer.hand_over()
            return start_ns, world.failure, observer.evidence, observer.violations

        checksum = manager.checksum()
        _check_same(spec.manager, checksum, known)
        nodes = current_system().nodes if spec.extensions else ()
        outcome = isolate(spec, run_isolated, kept=manager.process.descriptors, nodes=nodes)
        _check_same(spec.manager, manager.checksum(), checksum)
    writer.take_over()
    return _Outcome(*outcome, checksum, manager.imported_versions())


def _run_live(
    spec: RunSpec, resources: Resources, writer: RecordWriter, *, log: bool, known: str | None
) -> _Outcome:
    from sunset.experiments.live_run import LiveWatch, run_live  # noqa: PLC0415  needs an optional extra

    checksum, imported = checksum_and_versions(spec.manager, spec.settings)
    _check_same(spec.manager, checksum, known)
    with system_with(fault.name for fault in spec.scenario.faults):
        watch = LiveWatch(spec, writer)
        start_ns, failure = run_live(spec, resources, watch, log=log)
    _check_same(spec.manager, manager_checksum(spec.manager, spec.settings), checksum)

    def shortfall(timeline: Timeline) -> tuple[str, int]:
        times = (start_ns, timeline, spec.timing)
        return watch.frames.shortfall(*times), watch.frames.losses(*times)[1]

    return _Outcome(start_ns, failure, watch.evidence, watch.violations, checksum, imported, shortfall)


def _check_same(manager: str, checksum: str, known: str | None) -> None:
    if known not in {None, checksum}:
        raise ManagerError(
            f"The managing system {manager} was changed while it was run; run the new one in a new folder."
        )


def describe(spec: RunSpec, resources: Resources) -> RunRecord:
    """Return the record of a run before it has a result: its full specification, without paths and wall clock."""
    settings, card, timing, live = spec.settings, resources.model.card, spec.timing, spec.settings.live
    described = RunRecord(
        scenario=spec.scenario.name,
        faults=stored_faults(resources.scenario, spec.scenario),
        suite=spec.suite,
        suite_size=suite_size(spec.suite) or spec.suite_size,
        alike=degradations_of(fault.name for fault in spec.scenario.faults),
        manager=spec.manager_name,
        manager_spec=spec.manager if spec.label else UNSET,
        missing_walls=_missing_walls(spec.manager),
        seed=spec.seed,
        model=card.name,
        model_checksums={str(modality): network.digest for modality, network in card.networks.items()},
        device=resources.segmenter.device,
        middleware=settings.middleware,
        compute_s=UNSET if live else dict(current_system().compute_s),
        jitter=UNSET if live else timing.jitter,
        latency_s=UNSET if live else timing.latency_s,
        speed=settings.speed if live else UNSET,
        viewers=list(settings.viewers) or UNSET,
        warm_up_s=timing.warm_up_s,
        duration_s=timing.duration_s,
        period_s=timing.period_s,
        expected_frames=timing.expected_frames,
        entropy_threshold=card.entropy_threshold,
        sharpness_threshold=card.sharpness_threshold,
        extensions={extension.name: extension.checksum for extension in spec.extensions} or UNSET,
        versions=versions() | (live_middleware(settings.middleware).versions() if live else {}),
        metrics={},
        valid=True,
        reason="",
    )
    stored = {name: getattr(settings, name) or UNSET for name in SETTINGS}
    return replace(_with_flight(described, spec, resources), **stored)


def _with_flight(described: RunRecord, spec: RunSpec, resources: Resources) -> RunRecord:
    bag = resources.bag
    return replace(
        described,
        flight=flight_name(spec),
        flight_conditions=(not spec.flight.bag and spec.flight.conditions()) or UNSET,
        flight_warning=resources.warning or UNSET,
        bag_frames=len(bag),
        bag_checksum=resources.bag_checksum,
        bag_looped=spec.settings.loop,
        bag_size=list(bag.recorded_size),
        bag_dropped=sum(bag.dropped.values()),
        frame_size=list(bag.size),
    )


def _missing_walls(manager: str) -> tuple[str, ...] | UnsetType:
    """Return which walls around a user's own managing system are missing; unset for all others."""
    if manager in {*MANAGERS, EXTERNAL}:
        return UNSET
    return tuple(WALLS if is_registered(manager) else missing_walls())


def versions() -> dict[str, str]:
    """Return the versions of everything that a record's bytes may depend on."""
    return {
        "sunset": package_version(),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "onnxruntime": onnxruntime.__version__,  # whichever package it came with
        **{name: version(name) for name in ("numpy", "opencv-python-headless", "rosbags")},
    }

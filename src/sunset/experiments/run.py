"""One experiment: from its specification to its record and its metrics."""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

import onnxruntime
from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from sunset.confinement import WALLS, missing_walls
from sunset.errors import ManagerError
from sunset.experiments.manager import check_name, checksum_and_versions, isolate, manager_checksum
from sunset.experiments.observer import Observer, shown_topics
from sunset.experiments.parameters import known_scenario, manager_parameters
from sunset.experiments.resources import Resources, flight_name, prepare
from sunset.experiments.simulated import run_simulated
from sunset.experiments.spec import RunSpec
from sunset.experiments.stored_faults import stored_faults
from sunset.harness.confined_manager import manager_process
from sunset.harness.manager_process import ManagerSpec
from sunset.interfaces.stamps import NS_PER_S, ns_of
from sunset.interfaces.system_interfaces.msg import Command, FaultInjection
from sunset.managing import EXTERNAL, MANAGERS, is_registered
from sunset.metrics import Evidence, RunMetrics, Timeline, score
from sunset.processes.calls import Watch
from sunset.recording import (
    RecordedMessage,
    RecordWriter,
    RunRecord,
    StoredRun,
    log_of,
    story_topics,
    timeline_of,
)
from sunset.rmw.backends import live_middleware
from sunset.scenarios import Scenario
from sunset.source_files import package_version
from sunset.system import current_system, degradations_of, short_name, suite_size, system_with

_AT_ONCE_S: Final = 0.1
"""Faults that are due when the measured time begins are injected by then."""


def run(spec: RunSpec, folder: Path, *, log: bool = False) -> StoredRun:
    """Run one experiment, write its record to a new folder, and score it.

    The folder appears when the run is complete, under its final name. A simulated experiment takes place in a process
    of its own, and the managing system in another one; what is measured is computed here, from the recorded messages
    and from nothing else. Where the managing system fails, the run goes on without one, and the record says so.

    Args:
        spec: what is run.
        folder: the record's folder, which must not exist, or be empty.
        log: whether what the managing system logs goes to stderr as well as to the record.

    Raises:
        ManagerError: the managing system could not be loaded, or was changed meanwhile.
        ExtensionError: a node of the extended system raised, hung, or ended its process, in the simulation.
        ModelError: the model cannot be used.
        DataError: the bag cannot be used.
        OutputError: the record cannot be written.
    """
    spec.load_extensions()
    return run_prepared(spec, prepare(spec), folder, log=log)


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
    """Run one experiment with what `prepare` has found, its extensions loaded; as `run`.

    Args:
        spec: what is run.
        resources: what `prepare` has found.
        folder: the record's folder.
        log: as of `run`.
        known: the checksum that the managing system's files must have; None for any.
        wanted: whether images of a topic are kept, where any are; None for all.
        played: commands of a record, which are played back; in the simulation.
    """
    described = _describe(spec, resources)
    with RecordWriter(folder, images=spec.settings.images, wanted=wanted) as writer:
        conduct = _run_live if spec.settings.live else partial(_run_simulated, played=played)
        outcome = conduct(spec, resources, writer, log=log, known=known)
        messages = writer.messages(story_topics())
        observed = timeline_of(described, messages)
        figures = score(observed)
        shortfall, frames_lost = outcome.shortfall(observed)
        reasons = [
            *outcome.violations,
            *_unconfirmed(messages, spec.scenario, outcome.start_ns),
            *_unseen(observed),
            *filter(None, [shortfall]),
        ]
        stored = writer.close(
            replace(
                described,
                manager_checksum=outcome.manager_checksum,
                manager_versions=outcome.manager_versions or UNSET,
                manager_failed=outcome.failure or None,
                evidence=outcome.evidence,
                start_ns=outcome.start_ns,
                metrics=figures.to_json(),
                fault_outcomes=figures.outcomes,
                computer_kept_up=not shortfall if spec.settings.live else UNSET,
                frames_lost=frames_lost,
                valid=not reasons,
                reason="; ".join(reasons),
            )
        )
    return StoredRun(folder, stored, observed, figures, log_of(messages))


def _unconfirmed(messages: Sequence[RecordedMessage], scenario: Scenario, start_ns: int) -> Iterator[str]:
    """Yield which faults were refused, but for those that the scenario executor answers for when the time begins."""
    answered = {
        fault.name
        for fault in scenario.faults
        if fault.at == 0 and fault.after is None and fault.profile.rise is None
    }
    for recorded in messages:
        one = recorded.message
        if isinstance(one, FaultInjection) and not one.confirmed:
            time_s = (ns_of(one.stamp) - start_ns) / NS_PER_S
            if time_s > _AT_ONCE_S or one.fault not in answered:
                yield f"{short_name(one.node)} did not confirm {one.fault} at {time_s:.2f} s"


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
    """Write what stands in the place of a run that failed: a record without messages or figures.

    Its managing system or a node of an extension failed.

    Raises:
        OutputError: it cannot be written.
    """
    with RecordWriter(folder) as writer:
        writer.close(
            replace(
                _describe(spec, resources),
                manager_checksum=manager_checksum,
                manager_failed=reason,
                metrics=dict.fromkeys(RunMetrics.names()),
                valid=False,
                reason=reason.rstrip("."),
            )
        )


@dataclass(frozen=True)
class _Outcome:
    """What a run yields besides its messages.

    Attributes:
        start_ns: the time of the injection, nanoseconds of the experiment's clock.
        violations: what the managing system did that it must not.
        manager_checksum: of the managing system's files.
        shortfall: says why the computer could not keep up, if it could not, and how many frames it lost; in the
            simulation it always can.
        failure: how the managing system has failed, in a sentence; empty if it has not.
        manager_versions: of the distributions that the managing system imported when it was loaded.
        evidence: what the managing system looked at.
    """

    start_ns: int
    violations: tuple[str, ...]
    manager_checksum: str
    shortfall: Callable[[Timeline], tuple[str, int | UnsetType]] = lambda _: ("", UNSET)
    failure: str = ""
    manager_versions: Mapping[str, str] = field(default_factory=dict)
    evidence: Evidence = "symptoms"


def _run_simulated(
    spec: RunSpec,
    resources: Resources,
    writer: RecordWriter,
    *,
    log: bool,
    known: str | None,
    played: Sequence[Command],
) -> _Outcome:
    manager_spec = ManagerSpec(
        manager=spec.manager,
        limit_s=spec.settings.manager_limit_s,
        variables=spec.settings.manager_env,
        parameters=manager_parameters(spec, resources),
        log=log,
        scenario=known_scenario(spec, resources),
    )
    with manager_process(manager_spec) as manager:
        check_name(f"/{manager.loaded.node_name}", spec.manager)

        def run_isolated(watch: Watch) -> dict[str, object]:
            with system_with(fault.name for fault in spec.scenario.faults):
                observer = Observer(writer, shown=shown_topics(spec.manager), task=spec.settings.task)
                start_ns, failure = run_simulated(spec, resources, watch, manager, observer, played=played)
            manager.process.kill()
            writer.hand_over()
            return {
                "start_ns": start_ns,
                "violations": observer.violations,
                "failure": failure,
                "evidence": observer.evidence,
            }

        found = manager.checksum()
        _check_same(spec.manager, found, known)
        nodes = current_system().nodes if spec.extensions else ()
        told = isolate(spec, run_isolated, kept=manager.process.descriptors, nodes=nodes)
        _check_same(spec.manager, manager.checksum(), found)
    writer.take_over()
    return _Outcome(
        int(told["start_ns"]),
        tuple(told["violations"]),
        found,
        failure=str(told["failure"]),
        manager_versions=manager.imported_versions(),
        evidence=told["evidence"],
    )


def _run_live(
    spec: RunSpec, resources: Resources, writer: RecordWriter, *, log: bool, known: str | None
) -> _Outcome:
    from sunset.experiments import live_run  # noqa: PLC0415  needs an optional extra

    frames = live_run.FrameCount()
    found, imported = checksum_and_versions(spec.manager, spec.settings)
    _check_same(spec.manager, found, known)
    with system_with(fault.name for fault in spec.scenario.faults):
        observer = Observer(
            writer, shown=shown_topics(spec.manager), viewers=spec.settings.viewers, task=spec.settings.task
        )
        start_ns, failure = live_run.run_live(spec, resources, observer, frames, log=log)
    _check_same(spec.manager, manager_checksum(spec.manager, spec.settings), found)

    def shortfall(timeline: Timeline) -> tuple[str, int]:
        times = (start_ns, timeline, spec.timing)
        return frames.shortfall(*times), frames.losses(*times)[1]

    ended = ("the managing system ended it before its time",) if frames.ended_early else ()
    return _Outcome(
        start_ns,
        (*observer.violations, *ended),
        found,
        shortfall,
        failure,
        imported,
        observer.evidence,
    )


def _check_same(manager: str, found: str, known: str | None) -> None:
    """Check that a managing system's files have a known checksum, if there is one.

    Raises:
        ManagerError: they have another.
    """
    if known not in {None, found}:
        raise ManagerError(
            f"The managing system {manager} was changed while it was run; run the new one in a new folder."
        )


def _describe(spec: RunSpec, resources: Resources) -> RunRecord:
    """Return the full specification of a run as it is stored, before it has a result: no paths, no wall clock."""
    settings, card, bag = spec.settings, resources.model.card, resources.bag
    timing = spec.timing
    return RunRecord(
        scenario=spec.scenario.name,
        faults=stored_faults(resources.scenario, spec.scenario),
        suite=spec.suite,
        suite_size=suite_size(spec.suite, spec.scenario.name) or spec.suite_size,
        alike=degradations_of(fault.name for fault in spec.scenario.faults),
        manager=spec.manager_name,
        manager_spec=spec.manager if spec.label else UNSET,
        missing_walls=_missing_walls(spec.manager),
        seed=spec.seed,
        model=card.name,
        model_checksums={str(modality): network.digest for modality, network in card.networks.items()},
        device=resources.segmenter.device,
        middleware=settings.middleware,
        flight=flight_name(spec),
        flight_conditions=(not spec.flight.bag and spec.flight.conditions()) or UNSET,
        flight_warning=resources.warning or UNSET,
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
        viewers=list(settings.viewers) or UNSET,
        warm_up_s=timing.warm_up_s,
        duration_s=timing.duration_s,
        period_s=timing.period_s,
        task=settings.task,
        thinking_s=settings.thinking_s or UNSET,
        expected_frames=timing.expected_frames,
        entropy_threshold=card.entropy_threshold,
        sharpness_threshold=card.sharpness_threshold,
        extensions={extension.name: extension.checksum for extension in spec.extensions} or UNSET,
        versions=versions() | (live_middleware(settings.middleware).versions() if settings.live else {}),
        metrics={},
        valid=True,
        reason="",
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

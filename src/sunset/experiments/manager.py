"""The managing system and the nodes of an experiment: their parameters, and the errors that they cause."""

import contextlib
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Final, TypeVar, cast

from sunset.errors import ExtensionError, ManagerError, ScenarioError, SunsetError
from sunset.experiments.observer import Observer
from sunset.experiments.resources import Resources
from sunset.experiments.settings import Settings
from sunset.experiments.spec import RunSpec
from sunset.files.sources import PACKAGES
from sunset.harness.confined_manager import manager_process
from sunset.harness.manager_process import ManagerSpec
from sunset.images import cache as image_cache
from sunset.managing import EXTERNAL, ORACLE, KnownFault, KnownScenario
from sunset.processes.calls import Watch, call_isolated
from sunset.processes.process import ProcessDeath, killed_error
from sunset.system import BAG_PLAYER, Value, current_system
from sunset.texts.sentences import described_error, line_text
from sunset_ros import CallbackError
from sunset_ros.seeding import drawn_seed, generator

_Result = TypeVar("_Result")

_STILL_S: Final = 60.0
"""Processor time beyond the limit of its managing system that a simulation may take without a sign of life."""


Parameters = dict[str, Value]


def manager_checksum(manager: str, settings: Settings) -> str:
    """Load a managing system in a process of its own; return the checksum of its files, empty for `external`."""
    return checksum_and_versions(manager, settings)[0]


def checksum_and_versions(manager: str, settings: Settings) -> tuple[str, dict[str, str]]:
    """Do as `manager_checksum`; return also the versions of the distributions that it imported, by name."""
    if manager == EXTERNAL:
        return "", {}
    spec = ManagerSpec(manager=manager, limit_s=settings.manager_limit_s, variables=settings.manager_env)
    with manager_process(spec) as process:
        check_name(f"/{process.loaded.node_name}", manager)
        return process.checksum(), process.imported_versions()


def isolate(
    spec: RunSpec, function: Callable[[Watch], _Result], *, kept: Collection[int], nodes: Collection[str] = ()
) -> _Result:
    """Call a function in which a run takes place as `call_isolated` does; the code of `nodes` may be an extension's."""
    try:
        return call_isolated(function, limit_s=spec.settings.manager_limit_s + _STILL_S, kept=kept)
    except ProcessDeath as death:
        if death.running in nodes:
            raise ExtensionError(
                f"The node {death.running} failed in {spec.scenario.name}, seed {spec.seed}: it {death.reason}"
                f"{_foreign_place(death.frames[::-1])}."
            ) from death
        raise killed_error(death, "run") from death


def check_name(name: str, manager: str) -> None:
    """Refuse a managing system whose node has the full name of a node of the system."""
    if name in current_system().all_nodes:
        raise ManagerError(
            f"The managing system {manager} has the name {name}, which is a node of the system; give its class another "
            "node_name."
        )


def bring_up_timeout_error(
    spec: RunSpec, limit_s: float, missing: Mapping[str, str], commands: int, *, disturbed: bool = False
) -> SunsetError:
    """Return the error for nodes that are not all active in time.

    `missing` has the state of each such node, and `commands` is the number of requests that the managing system sent
    meanwhile. `disturbed` says whether a node's process has ended in order, as if shut down through its lifecycle.
    """
    states = ", ".join(f"{node} is {state}" for node, state in missing.items())
    hint = (
        f"; the managing system {spec.manager} sent {commands} requests meanwhile: it should leave nodes alone until "
        "the system is up, which adapt waits for"
    )
    kind = ManagerError if commands or disturbed else SunsetError
    return kind(
        f"The managed system did not come up within {limit_s:g} s in {spec.scenario.name}, seed {spec.seed}: {states}"
        f"{hint if commands else ''}."
    )


def check_injection(problem: str, observer: Observer) -> None:
    """Report a failed injection: as a violation if the managing system sent requests, otherwise as an error.

    `problem` is empty if nothing failed.
    """
    if problem and not observer.commands:
        raise ScenarioError(f"{problem[:1].upper()}{problem[1:]}.")
    if problem:
        observer.note(f"{problem} (requests of the managing system: {observer.commands})")


def node_error(
    spec: RunSpec, node: str, error: BaseException, *, starting: bool = False
) -> ExtensionError | None:
    """Return the error for an extension's code that raised in a node; None if SUNSET itself raised.

    Code of an extension, a class or the effect of a fault, runs in a managed node.
    """
    cause = error.origin if isinstance(error, CallbackError) else error
    if cause is not error and isinstance(cause, ExtensionError):  # a redeployed node could not be started
        return cause
    frames = traceback.extract_tb(cause.__traceback__)
    place = _foreign_place([(frame.filename, frame.lineno or 0, frame.name) for frame in frames])
    # no node causes an error of the cache
    is_own = isinstance(cause, SunsetError) and (not place or frames[-1].filename == image_cache.__file__)
    if is_own or not spec.extensions or node not in current_system().nodes:
        return None
    if starting:
        return ExtensionError(f"The node {node} could not be started: {described_error(cause)}{place}.")
    return ExtensionError(
        f"The node {node} failed in {spec.scenario.name}, seed {spec.seed}: it raised {described_error(cause)}{place}."
    )


def _foreign_place(frames: Sequence[tuple[str, int, str]]) -> str:
    """Return the last line that ran of the first file outside SUNSET, as text; the frames are outermost first."""
    # an exception that leaves a context of ours passes through contextlib
    own = {*PACKAGES.values(), Path(contextlib.__file__)}
    foreign = [frame for frame in frames if not own & {Path(frame[0]), *Path(frame[0]).parents}]
    if not foreign:
        return ""
    return line_text(*[frame for frame in foreign if frame[0] == foreign[0][0]][-1])


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


def manager_spec_of(spec: RunSpec, resources: Resources, *, log: bool) -> ManagerSpec:
    """Return a run's managing system, whose log goes to stderr, too, if `log` is true."""
    clock: Parameters = {"use_sim_time": True} if spec.settings.live else {}
    return ManagerSpec(
        manager=spec.manager,
        limit_s=spec.settings.manager_limit_s,
        variables=spec.settings.manager_env,
        parameters=clock | manager_parameters(spec, resources),
        log=log,
        live=spec.settings.live,
        scenario=_known_scenario(spec, resources),
    )


def _known_scenario(spec: RunSpec, resources: Resources) -> KnownScenario | None:
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

"""The managing system as part of an experiment: how it is made, and what is said if it or a node fails."""

import inspect
import signal
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from sunset.errors import ExtensionError, ManagerError, ScenarioError, SunsetError
from sunset.experiments.observer import Observer
from sunset.experiments.parameters import Parameters
from sunset.experiments.spec import EXTERNAL, RunSpec
from sunset.isolation import ProcessDeath, UnexpectedError, Watch, call_isolated
from sunset.managing import MANAGERS, ManagingSystem, checksum, load_manager, manager_sources
from sunset.ros import CallbackError, Context, Parameter
from sunset.system import MANAGER_PROCESS, current_system
from sunset.texts import shorten

_PACKAGE: Final = Path(__file__).parents[1]


def manager_factory(
    spec: RunSpec, made: type[ManagingSystem], parameters: Parameters, watch: Watch
) -> Callable[[Context], ManagingSystem]:
    """Return what makes the managing system; whatever goes wrong in its constructor is its own error."""
    overrides = [Parameter(name, value=value) for name, value in parameters.items()]

    def make(context: Context) -> ManagingSystem:
        try:
            manager = watch.call(lambda: made(context=context, parameter_overrides=overrides))
            name = manager.get_fully_qualified_name()
        except ManagerError:
            raise
        except BaseException as error:
            raise ManagerError(
                f"The managing system {spec.manager} could not be constructed: it raised "
                f"{_described(error)}{_place(made, error)}."
            ) from error
        check_name(name, spec.manager)
        return manager

    return make


def manager_checksum(manager: str, *, limit_s: float) -> str:
    """Load a managing system in a process of its own; return the checksum of its files, of `external` an empty text.

    Args:
        manager: its name, as of `load_manager`.
        limit_s: seconds of wall time that loading it may take.

    Raises:
        ManagerError: it cannot be loaded.
    """

    def load() -> str:
        made = load_manager(manager)
        check_name(f"/{made.node_name}", manager)
        return checksum(manager, manager_sources(manager, made))

    if manager == EXTERNAL:
        return ""
    return str(isolate(manager, "cannot be loaded", lambda watch: watch.call(load), limit_s=limit_s))


def isolate(
    manager: str,
    what: str,
    function: Callable[[Watch], Any],
    *,
    limit_s: float,
    nodes: Collection[str] = (),
) -> Any:
    """Call a function in which a managing system runs in a process of its own, and return what it returns.

    `what` says of the managing system what happened if the call fails, such as `cannot be loaded`; the function and the
    limit are those of `call_isolated`; the nodes are those whose code is not SUNSET's own, or need not be.

    Raises:
        ManagerError: it raised, hung, or ended its process.
        ExtensionError: one of the nodes did.
        SunsetError: what the function raised.
    """
    try:
        return call_isolated(function, limit_s=limit_s)
    except ProcessDeath as death:
        raise _death_error(manager, what, death, nodes) from death
    except UnexpectedError as error:
        if manager in MANAGERS:
            raise
        last = (str(error).strip().splitlines() or ["an error without a text"])[-1]
        raise ManagerError(f"The managing system {manager} {what}: it ended in {shorten(last)}.") from error


def _death_error(manager: str, what: str, death: ProcessDeath, nodes: Collection[str]) -> SunsetError:
    """Return what a user is told when the process of a managing system ended; as `isolate`."""
    if death.running in nodes:
        return ExtensionError(
            f"The node {death.running} {what}: it {death.reason}{_foreign_place(death.frames[::-1])}."
        )
    if manager in MANAGERS or (nodes and death.running != MANAGER_PROCESS):
        killed = signal.SIGKILL.name in death.reason
        cause = ": it was killed, for instance for want of memory" if killed else ""
        remedy = ", with fewer --jobs if memory was short" if killed else ""
        return SunsetError(
            f"The process of the run {death.reason}{cause}; what was finished is kept: run the same command "
            f"again{remedy}."
        )
    source = Path(manager.rpartition(":")[0])
    places = [
        f" ({source.name}, line {line}, in {function})"
        for file, line, function in death.frames
        if source.suffix and Path(file) == source.resolve()
    ]
    return ManagerError(f"The managing system {manager} {what}: it {death.reason}{''.join(places[:1])}.")


def check_name(name: str, given: str) -> None:
    """Refuse a managing system whose node has the full name of another; `given` is what the user calls it.

    Raises:
        ManagerError: it has.
    """
    if name in current_system().all_nodes:
        raise ManagerError(
            f"The managing system {given} has the name {name}, which is a node of the system; give its class another "
            "node_name."
        )


def bring_up_timeout_error(
    spec: RunSpec, limit_s: float, missing: Mapping[str, str], commands: int, *, disturbed: bool = False
) -> SunsetError:
    """Return what a user is told when nodes are not all active in time.

    Args:
        spec: the run.
        limit_s: how long was waited, in seconds.
        missing: node → its state, of those that are not as they should be.
        commands: how many requests of the managing system they had meanwhile.
        disturbed: whether the process of a managed node has ended in order, as if shut down through its lifecycle.
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
    """Hold a problem of the injection, if there is one, against a managing system that has requested anything.

    Raises:
        ScenarioError: they could not, and the managing system has done nothing.
    """
    if problem and not observer.commands:
        raise ScenarioError(f"{problem[:1].upper()}{problem[1:]}.")
    if problem:
        observer.violations[f"{problem} (requests of the managing system: {observer.commands})"] = None


def manager_error(spec: RunSpec, manager: ManagingSystem, error: BaseException) -> ManagerError:
    """Return what a user is told when a callback of the managing system raised."""
    cause = error.__cause__ if isinstance(error, CallbackError) and error.__cause__ else error
    if isinstance(cause, ManagerError):  # a program's own words
        told = str(cause).removesuffix(".")
        told = f"{told[:1].lower()}{told[1:]}"
    else:
        told = f"it raised {_described(cause)}{_place(type(manager), cause)}"
    return ManagerError(
        f"The managing system {spec.manager} failed in {spec.scenario.name}, seed {spec.seed}: {told}."
    )


def node_error(
    spec: RunSpec, node: str, error: BaseException, *, starting: bool = False
) -> ExtensionError | None:
    """Return what a user is told when a node raised, in its constructor or a callback; None if SUNSET itself did.

    Whatever code an extension adds, a class or the effect of a fault, runs in a managed node.
    """
    cause = error.__cause__ if isinstance(error, CallbackError) and error.__cause__ else error
    if cause is not error and isinstance(cause, ExtensionError):  # a redeployed node could not be started
        return cause
    place = _foreign_place(
        [
            (frame.filename, frame.lineno or 0, frame.name)
            for frame in traceback.extract_tb(cause.__traceback__)
        ]
    )
    if (
        not spec.extensions
        or node not in current_system().nodes
        or (isinstance(cause, SunsetError) and not place)
    ):
        return None
    if starting:
        return ExtensionError(f"The node {node} could not be started: {_described(cause)}{place}.")
    return ExtensionError(
        f"The node {node} failed in {spec.scenario.name}, seed {spec.seed}: it raised {_described(cause)}{place}."
    )


def _foreign_place(frames: Sequence[tuple[str, int, str]]) -> str:
    """Return which line of the first file that is not SUNSET's was the last to run; the frames are outermost first."""
    foreign = [frame for frame in frames if not Path(frame[0]).is_relative_to(_PACKAGE)]
    if not foreign:
        return ""
    file, line, function = [frame for frame in foreign if frame[0] == foreign[0][0]][-1]
    return f" ({Path(file).name}, line {line}, in {function})"


def _described(error: BaseException) -> str:
    try:
        text = shorten(str(error).rstrip("."))
    except Exception:  # noqa: BLE001  str() of a user's exception may itself raise
        text = ""
    return ": ".join(filter(None, (type(error).__name__, text)))


def _place(manager: type[ManagingSystem], error: BaseException) -> str:
    """Return which line of the managing system's file was the last to run: ` (mine.py, line 7, in adapt)`."""
    try:
        source = inspect.getsourcefile(manager)
    except (OSError, TypeError):  # a class of a notebook
        source = inspect.getfile(manager.adapt)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == source]
    if source is None or not frames:
        return ""
    return f" ({Path(source).name}, line {frames[-1].lineno}, in {frames[-1].name})"

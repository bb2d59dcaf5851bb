"""The managing system as part of an experiment: how it is made, and what is said if it fails."""

import inspect
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path

from sunset.errors import ManagerError, SunsetError
from sunset.experiments.graph import SYSTEM_NODES
from sunset.experiments.spec import RunSpec
from sunset.managing import ManagingSystem, load_manager
from sunset.rmw.sim import LimitExceeded, run_limited
from sunset.ros import CallbackError, CallbackTimeoutError, Context, Parameter

__all__ = ["absent", "check_name", "failure", "manager_factory"]


def manager_factory(spec: RunSpec, entropy_threshold: float) -> Callable[[Context], ManagingSystem]:
    """Return what makes the managing system; whatever goes wrong in its constructor is its own error.

    Raises:
        ManagerError: there is no such managing system.
    """
    made = load_manager(spec.manager)
    overrides = [Parameter("entropy_threshold", value=entropy_threshold)]

    def make(context: Context) -> ManagingSystem:
        try:
            manager = run_limited(
                spec.manager_limit_s, lambda: made(context=context, parameter_overrides=overrides)
            )
            name = manager.get_fully_qualified_name()
        except LimitExceeded as error:
            raise ManagerError(
                f"The managing system {spec.manager} cannot be made: it did not return within "
                f"{spec.manager_limit_s:g} s{_place(made, error)}."
            ) from error
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ManagerError(
                f"The managing system {spec.manager} cannot be made: it raised "
                f"{_described(error)}{_place(made, error)}."
            ) from error
        check_name(name, spec.manager)
        return manager

    return make


def check_name(name: str, given: str) -> None:
    """Refuse a managing system whose node has the full name of another; `given` is what the user calls it.

    Raises:
        ManagerError: it has.
    """
    if name in SYSTEM_NODES:
        raise ManagerError(
            f"The managing system {given} has the name {name}, which is a node of the system; give its class another "
            "node_name."
        )


def absent(spec: RunSpec, limit_s: float, missing: Mapping[str, str], commands: int) -> SunsetError:
    """Return what a user is told when nodes are not all active in time.

    Args:
        spec: what was to be flown.
        limit_s: how long was waited, in seconds.
        missing: node → its state, of those that are not as they should be.
        commands: how many requests of the managing system they had meanwhile.
    """
    states = ", ".join(f"{node} is {state}" for node, state in missing.items())
    hint = (
        f"; the managing system {spec.manager} sent {commands} requests meanwhile: it should leave nodes alone until "
        "they have been active once, which symptoms.stopped() knows"
    )
    return SunsetError(
        f"The managed system did not come up within {limit_s:g} s in {spec.scenario.name}, seed {spec.seed}: {states}"
        f"{hint if commands else ''}."
    )


def failure(spec: RunSpec, manager: ManagingSystem, error: BaseException) -> ManagerError:
    """Return what a user is told when a callback of the managing system raised or did not return."""
    cause = error.__cause__ if isinstance(error, CallbackError) and error.__cause__ else error
    what = (
        str(error).rstrip(".")
        if isinstance(error, CallbackTimeoutError)
        else f"it raised {_described(cause)}"
    )
    return ManagerError(
        f"The managing system {spec.manager} failed in {spec.scenario.name}, seed {spec.seed}: {what}"
        f"{_place(type(manager), cause)}."
    )


def _described(error: BaseException) -> str:
    try:
        text = str(error).rstrip(".")
    except Exception:  # noqa: BLE001  a class of the user's, whose text is a mistake of its own
        text = ""
    return ": ".join(filter(None, (type(error).__name__, text)))


def _place(manager: type[ManagingSystem], error: BaseException) -> str:
    """Return which line of the managing system's file was the last to run: ` (mine.py, line 7, in adapt)`."""
    source = inspect.getsourcefile(manager)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == source]
    if source is None or not frames:
        return ""
    return f" ({Path(source).name}, line {frames[-1].lineno}, in {frames[-1].name})"

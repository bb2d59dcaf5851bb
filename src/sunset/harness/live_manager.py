"""The managing system of a live run: a process on the network, whose callbacks another one runs behind walls."""

from collections.abc import Mapping, Sequence

from sunset.harness.confined_manager import manager_process
from sunset.managing import KnownScenario
from sunset.rmw.remote import Gateway, PipeError
from sunset.ros import Context
from sunset.system import Value


def run_confined(
    manager: str,
    context: Context,
    *,
    limit_s: float,
    variables: Sequence[str],
    parameters: Mapping[str, Value],
    occasion: str,
    scenario: KnownScenario | None = None,
) -> str:
    """Be on the network for a managing system in a confined process, until it leaves, fails, or a signal comes.

    While it runs a callback, this process waits for it; what comes meanwhile is kept as its QoS says.

    Args:
        manager: its name, as of `load_manager`.
        context: this process, whose shutdown ends it.
        limit_s: seconds of wall time that loading it, and each of its callbacks, may take.
        variables: names of environment variables that it gets.
        parameters: of its node, by name.
        occasion: what it may fail in, such as `gpu_failure, seed 1`.
        scenario: that of the run, which only the oracle is told.

    Returns:
        How it has failed, in a sentence; empty if it has not.

    Raises:
        ManagerError: it cannot be loaded.
        SunsetError: no process can be started for it.
    """
    middleware = context.middleware
    failures: list[str] = []
    what = "could not be constructed"
    with manager_process(
        manager,
        limit_s=limit_s,
        variables=variables,
        parameters=parameters,
        log=True,
        live=True,
        describes_types=middleware.describes_types,
        scenario=scenario,
    ) as process:
        is_wanted = context.ok()

        def leave() -> None:
            nonlocal is_wanted
            is_wanted = False
            process.interrupt()

        def note(failure: PipeError) -> None:
            if is_wanted:  # else it was interrupted
                failures.append(process.describe(failure, what))

        context.on_shutdown(leave)
        gateway = Gateway(
            middleware, process.pipe, limit_s=process.longest_s, end=middleware.shutdown, on_failure=note
        )
        if is_wanted:
            gateway.start()
        what = f"failed in {occasion}"
        while middleware.alive:
            middleware.spin_once(None)
        process.end()
    return "".join(failures)

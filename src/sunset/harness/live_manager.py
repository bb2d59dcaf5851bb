"""The managing system of a live run: a node on the network, whose callbacks a confined process runs."""

from sunset.harness.confined_manager import manager_process
from sunset.harness.manager_process import ManagerSpec
from sunset.rmw.remote import Gateway, PipeError
from sunset.ros import Context


def run_confined(spec: ManagerSpec, context: Context, *, occasion: str) -> str:
    """Be on the network for a managing system in a confined process, until it leaves or fails, or a signal comes.

    This process waits while the managing system runs a callback; its QoS keeps messages meanwhile.

    Args:
        spec: the managing system.
        context: of this process; its shutdown ends the managing system.
        occasion: the run, in words, such as `gpu_failure, seed 1`.

    Returns:
        How it has failed, in a sentence; empty if it has not.

    Raises:
        ManagerError: it cannot be loaded.
        SunsetError: no process can be started for it.
    """
    middleware = context.middleware
    failures: list[str] = []
    moment = "could not be constructed"
    with manager_process(spec, describes_types=middleware.describes_types) as process:
        is_wanted = context.ok()

        def leave() -> None:
            nonlocal is_wanted
            is_wanted = False
            process.interrupt()

        def note(failure: PipeError) -> None:
            if is_wanted:  # else it was interrupted
                failures.append(process.describe(failure, moment))

        context.on_shutdown(leave)
        gateway = Gateway(
            middleware, process.pipe, limit_s=process.longest_s, end=middleware.shutdown, on_failure=note
        )
        if is_wanted:
            gateway.start()
        moment = f"failed in {occasion}"
        while middleware.alive:
            middleware.spin_once(None)
        process.end()
    return "".join(failures)

"""One run of a campaign, whichever process does it."""

from pathlib import Path

from sunset.errors import ExtensionError, ManagerError, MiddlewareError
from sunset.experiments.resources import Resources, prepare
from sunset.experiments.run import record_failure, run_prepared
from sunset.experiments.spec import RunSpec
from sunset.managing import MANAGERS


def run_of_campaign(spec: RunSpec, folder: Path, known: str | None) -> None:
    """Load and prepare what a run needs, and do it as `record_run`.

    Raises:
        SunsetError: the run failed, and neither its managing system nor an extension's node is the reason.
    """
    spec.load_extensions()
    record_run(spec, prepare(spec), folder, known)


def record_run(spec: RunSpec, resources: Resources, folder: Path, known: str | None) -> None:
    """Do a run; one whose managing system, or an extension's node, fails is recorded as such.

    Args:
        spec: the run.
        resources: what it is made with.
        folder: of the record.
        known: the checksum that the managing system's files must have; None for any.

    Raises:
        SunsetError: the run failed, and neither is the reason.
    """
    try:
        run_prepared(spec, resources, folder, known=known)
    except (ManagerError, MiddlewareError, ExtensionError) as error:
        # what has misused the middleware in the simulation is what is not SUNSET's own there
        ours = spec.manager in MANAGERS or (spec.settings.live and isinstance(error, MiddlewareError))
        if ours and not isinstance(error, ExtensionError):
            raise
        record_failure(spec, resources, folder, manager_checksum=known or "", reason=str(error))

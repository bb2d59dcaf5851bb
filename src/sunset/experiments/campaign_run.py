"""A run of a campaign, in any process."""

from pathlib import Path

from sunset.errors import ExtensionError, ManagerError, MiddlewareError
from sunset.experiments.resources import Resources, prepare
from sunset.experiments.run import record_failure, run_prepared
from sunset.experiments.spec import RunSpec
from sunset.managing import MANAGERS


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

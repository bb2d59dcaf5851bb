"""Stored runs: run again to compare their messages, or played back for their images."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

from msgspec import UNSET

from sunset.errors import RecordError
from sunset.experiments.resources import Resources, prepare
from sunset.experiments.run import run_prepared
from sunset.experiments.settings import Settings, Timing
from sunset.experiments.spec import RunSpec, scenario_of
from sunset.flights import FlightSpec
from sunset.managing import MANAGERS, checksum, is_registered
from sunset.recording import SETTINGS, RunRecord, StoredRun, image_digests, read_messages, read_run
from sunset.recording.reader import check_extensions, first_difference
from sunset.system_interfaces.msg import Command
from sunset_ros.rmw.backends import SIMULATED
from sunset_ros.texts import shown

_CAUSES: Final = {
    "model_checksums": "the model",
    "manager_checksum": "the managing system",
    "manager_versions": "what it imported",
    "compute_s": "the nodes' compute times",
    "versions": "the versions",
}
"""Field of a record → its name for messages: the causes for which two runs of a specification may differ."""


def run_again(
    folder: Path,
    into: Path,
    *,
    manager: str | None = None,
    trust: bool = False,
    model: str | None = None,
    bag: Path | None = None,
    images: bool = False,
) -> StoredRun:
    """Run a stored run of the simulation again, with its extensions loaded, and check that it leaves the same messages.

    Args:
        folder: the record.
        into: the new record's folder, which must not exist, or be empty.
        manager: the managing system, if the record's name does not load it.
        trust: whether the managing system that the record names may run if it is a program.
        model: the model, if it is not installed under the record's name.
        bag: its bag, if it is not the default flight.
        images: whether the new record keeps images.

    Raises:
        RecordError: the run was live, or failed, or names code that is not trusted, or the messages differ.
    """
    stored = read_run(folder)
    name = stored.manager_spec or stored.manager
    is_program = name not in MANAGERS and not is_registered(name)  # a class that was passed is the user's own
    if is_program and manager is None and not trust:
        raise RecordError(
            f"The run in {folder} was made with the managing system {shown(name)}, which is code that the record "
            "names: read it, and say trust=True, or name it with manager."
        )
    spec, resources = _prepared(folder, stored, manager or name, model, bag, images=images)
    if is_program and not is_registered(spec.manager):
        _check_source(stored, spec.manager, folder)
    again = run_prepared(spec, resources, into)
    if again.digest != stored.digest:
        raise _difference_error(stored, folder, again)
    return again


def _check_source(stored: RunRecord, manager: str, folder: Path) -> None:
    if stored.manager_checksum and stored.manager_checksum != checksum(manager):
        raise RecordError(
            f"The run in {folder} was made with other source than {shown(manager)} has now: restore it, or say with "
            "manager where it is."
        )


def _difference_error(stored: RunRecord, folder: Path, again: StoredRun) -> RecordError:
    causes = ", ".join(_differences(stored, again.record)) or "the record itself"
    where = first_difference(folder, again.folder)
    return RecordError(
        f"The run in {folder} was run again, and left other messages, {where}; what differs: {causes}. Name what it "
        "was made with, or make a new record."
    )


def play_back(
    folder: Path,
    into: Path,
    *,
    model: str | None = None,
    bag: Path | None = None,
    wanted: Callable[[str], bool] | None = None,
) -> int:
    """Make the images of a stored run of the simulation by its commands, without its managing system.

    Args:
        folder: the record.
        into: the folder for a record with the images, which must not exist, or be empty.
        model: as in `run_again`.
        bag: as in `run_again`.
        wanted: whether images of a topic are kept; None for all.

    Returns:
        How many images differ from the run's.

    Raises:
        RecordError: the run was live, or it failed.
        SunsetError: as in `run`.
    """
    stored = read_run(folder)
    spec, resources = _prepared(folder, stored, "none", model, bag, images=True)
    messages = read_messages(folder)
    commands = [recorded.message for recorded in messages if isinstance(recorded.message, Command)]
    played = [command for command in commands if command.successful or command.kind != "set_parameters"]
    run_prepared(spec, resources, into, wanted=wanted, played=played)
    return len(image_digests(messages) - image_digests(read_messages(into)))


def _prepared(
    folder: Path, stored: RunRecord, manager: str, model: str | None, bag: Path | None, *, images: bool
) -> tuple[RunSpec, Resources]:
    """Return the specification of a stored run, with another managing system, and its resources."""
    if stored.middleware != SIMULATED:
        raise RecordError(
            f"The run in {folder} cannot be run again: it was live, on {stored.middleware}, and only runs of the "
            f"simulation ({SIMULATED}) repeat to the byte."
        )
    if stored.is_empty:
        raise RecordError(f"The run in {folder} cannot be run again: it failed, and left no messages.")
    check_extensions(stored, folder)
    spec = _spec_of(stored, manager, model, bag, images=images)
    resources = prepare(spec)
    if resources.bag_checksum != stored.bag_checksum:
        named = "the default flight of this version" if bag is None else f"the bag {bag}"
        raise RecordError(
            f"The run in {folder} cannot be run again: it was made with other frames than {named} has; name its own "
            "bag with --bag, in Python with bag."
        )
    return spec, resources


def _spec_of(
    stored: RunRecord, manager: str, model: str | None, bag: Path | None, *, images: bool
) -> RunSpec:
    def known(names: Iterable[str]) -> dict[str, Any]:
        values = {name: getattr(stored, name, UNSET) for name in names}
        return {name: value for name, value in values.items() if value is not UNSET}

    return RunSpec(
        scenario=scenario_of(stored),
        manager=manager,
        label=stored.manager,
        seed=stored.seed,
        suite_size=stored.suite_size or 0,
        settings=Settings(
            model=model or stored.model,
            bag=bag,
            flight=FlightSpec.of(stored.flight_conditions) if stored.flight_conditions else None,
            loop=stored.bag_looped,
            timing=Timing(**known(field.name for field in fields(Timing))),
            device=stored.device,
            images=images,
            **known(SETTINGS),
        ),
    )


def _differences(stored: RunRecord, again: RunRecord) -> Iterator[str]:
    """Yield the differences between two runs that should be identical."""
    for name, cause in _CAUSES.items():
        before, now = getattr(stored, name), getattr(again, name)
        if before == now:
            continue
        if name.endswith("versions"):
            before, now = before or {}, now or {}
            parts = sorted(part for part in before | now if before.get(part) != now.get(part))
            yield ", ".join(f"{part} {before.get(part, 'none')} is {now.get(part, 'none')}" for part in parts)
        else:
            yield cause

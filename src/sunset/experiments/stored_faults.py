"""A scenario's faults as `run.json` keeps them."""

from sunset.recording import RunRecord, StoredFault
from sunset.scenarios import After, Profile, Scenario, ScenarioFault


def stored_faults(scenario: Scenario, asked: Scenario) -> list[StoredFault]:
    """Return the faults of a scenario for a record.

    `asked` is the same scenario with severities in place of the model's strengths.
    """
    return [
        StoredFault(**fault.to_mapping(), severity=wanted.severity)  # type: ignore[arg-type]  # as it checks itself
        for fault, wanted in zip(scenario.faults, asked.faults, strict=True)
    ]


def scenario_of(run: RunRecord) -> Scenario:
    """Return the scenario of a stored run."""
    faults = tuple(
        ScenarioFault(
            fault.name,
            fault.value if fault.severity is None else None,
            severity=fault.severity,
            at=fault.at,
            until=fault.until,
            profile=Profile(**fault.profile) if fault.profile else Profile(),  # type: ignore[arg-type]  # it checks itself
            after=After(**fault.after) if fault.after else None,  # type: ignore[arg-type]  # it checks itself
        )
        for fault in run.faults
    )
    return Scenario(run.scenario, faults, duration=run.duration_s)

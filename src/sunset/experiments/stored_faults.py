"""A scenario's faults as `run.json` keeps them."""

from sunset.recording import RunRecord, StoredFault
from sunset.scenarios import After, Profile, Scenario, ScenarioFault


def stored_faults(scenario: Scenario, asked: Scenario) -> list[StoredFault]:
    """Return the faults of a scenario for a record.

    Args:
        scenario: with the strengths that were injected.
        asked: the same, with the severities that were asked for.
    """
    found = []
    for fault, wanted in zip(scenario.faults, asked.faults, strict=True):
        content = fault.to_mapping()
        found.append(StoredFault(**content, severity=wanted.severity))  # type: ignore[arg-type]  # as it checks itself
    return found


def scenario_of(run: RunRecord) -> Scenario:
    """Return the scenario of a stored run.

    Raises:
        ScenarioError: no scenario has these faults.
    """
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

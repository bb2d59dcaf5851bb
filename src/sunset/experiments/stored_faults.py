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
            one.name,
            one.value if one.severity is None else None,
            severity=one.severity,
            at=one.at,
            until=one.until,
            profile=Profile(**one.profile) if one.profile else Profile(),  # type: ignore[arg-type]  # it checks itself
            after=After(**one.after) if one.after else None,  # type: ignore[arg-type]  # it checks itself
        )
        for one in run.faults
    )
    return Scenario(run.scenario, faults, duration=run.duration_s)

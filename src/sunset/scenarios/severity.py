"""From severities to strengths: a scenario says what a fault costs, and a model knows which strength does."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sunset.errors import ScenarioError
from sunset.scenarios.fault import ScenarioFault
from sunset.scenarios.schema import Scenario
from sunset.texts import listed


def with_strengths(
    scenario: Scenario, strengths: Mapping[str, Sequence[float | None]], model: str
) -> Scenario:
    """Return a scenario in which every fault has a strength, in place of a severity.

    Args:
        scenario: the scenario.
        strengths: of the model: fault → one for each severity; None where no strength costs so much.
        model: the model's name.

    Raises:
        ScenarioError: no strength of a fault is so severe for the model, or it is not known which is.
    """

    def strong(fault: ScenarioFault) -> ScenarioFault:
        if fault.severity is None:
            return fault
        known = strengths.get(fault.name)
        if known is None:
            raise ScenarioError(
                f"The scenario {scenario.name} gives {fault.name} a severity, and the model {model} does not know its "
                "strengths: give a value, or let 'sunset models curves' measure them."
            )
        value = known[fault.severity - 1]
        if value is None:
            reached = [str(number) for number, one in enumerate(known, 1) if one is not None]
            levels = f"the severities {listed(reached)} can" if reached else "no severity can"
            raise ScenarioError(
                f"The scenario {scenario.name} gives {fault.name} the severity {fault.severity}, which no strength "
                f"reaches with the model {model}; {levels}."
            )
        return replace(fault, value=value, severity=None)

    return replace(scenario, faults=tuple(map(strong, scenario.faults)))

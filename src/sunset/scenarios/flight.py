"""What a scenario says of the flight."""

from dataclasses import dataclass, fields
from typing import Final

from sunset.errors import ScenarioError
from sunset.system import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class ScenarioFlight:
    """The flight of a scenario: one that is rendered under some conditions, or a bag.

    Attributes:
        town: which town is flown over.
        height: of the flight [m].
        angle: at which the camera looks down [degrees].
        time: of the day.
        weather: its name.
        seed: of what is random in a rendered flight.
        bag: a rosbag2, in place of all others.

    Raises:
        ScenarioError: there is neither a condition nor a bag, or there are both.
    """

    town: Value | None = None
    height: Value | None = None
    angle: Value | None = None
    time: Value | None = None
    weather: Value | None = None
    seed: Value | None = None
    bag: str | None = None

    def __post_init__(self) -> None:
        """Check that something is said, and no two things that contradict each other."""
        given = self.to_mapping()
        if not given:
            raise ScenarioError(
                "The flight of a scenario must say something: leave it out for the default flight."
            )
        if self.bag is not None and len(given) > 1:
            raise ScenarioError(
                "The flight of a scenario is a bag, or rendered under conditions: leave out the bag, or the conditions."
            )
        if not isinstance(self.bag, str | None):
            raise ScenarioError(f"The bag of a scenario's flight must be a path, got {self.bag!r}.")

    def to_mapping(self) -> dict[str, Value]:
        """Return it as a scenario's file has it."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


FLIGHT_KEYS: Final = tuple(field.name for field in fields(ScenarioFlight))
"""What a scenario may say of its flight."""

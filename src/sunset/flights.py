"""Specifications of flights: the frames of a bag, or of a flight that is rendered under given conditions.

They are apart from rendering and reading, so that a scenario can name a flight.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Final

from msgspec import Meta

from sunset.errors import InvalidInputError
from sunset.files.schemas import check_fields
from sunset_ros.seeding import check_seed
from sunset_ros.texts import shown, suggestion

TOWNS: Final = range(1, 9)
"""The numbers of the towns."""
TIMES: Final = ("morning", "noon", "evening")
"""The times of day."""
WEATHERS: Final = ("clear", "hazy", "overcast")
"""The kinds of weather."""

_LABEL: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,39}")


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSpec:
    """A flight: a bag, or the conditions for rendering it. The length of a rendered flight depends on the run.

    Raises:
        InvalidInputError: a value is of another type or out of range, or there are conditions beside a bag.

    >>> FlightSpec(town=8, height=80.0, angle=90.0, time="evening", weather="hazy").name
    'town8-80m-90deg-evening-hazy'
    """

    bag: Path | None = None
    """A rosbag2 folder or file; None for a rendered flight."""
    town: Annotated[int, Meta(ge=TOWNS[0], le=TOWNS[-1], title="flight's town")] = 1
    height: Annotated[float, Meta(ge=20, le=300, title="flight's height [m]")] = 50.0
    """Above the town's centre or, below 45 m, above the street of the flight."""
    angle: Annotated[float, Meta(ge=0, le=90, title="flight's angle [degrees]")] = 60.0
    """Of the camera below the horizon."""
    time: str = "noon"
    """The time of day, one of `TIMES`."""
    weather: str = "clear"
    """One of `WEATHERS`."""
    seed: int = 0
    """Of the sensors' noise."""
    label: str = ""
    """Its name in tables, if not derived from the other attributes."""

    def __post_init__(self) -> None:
        check_fields(self)
        check_seed(self.seed)
        for kind, value, known in (("time of day", self.time, TIMES), ("weather", self.weather, WEATHERS)):
            if value not in known:
                raise InvalidInputError(
                    f"The flight's {kind} must be one of {', '.join(known)}, got {shown(value)}."
                )
        object.__setattr__(self, "height", float(self.height))
        object.__setattr__(self, "angle", float(self.angle))
        if self.bag is not None and self._changed():
            raise InvalidInputError(
                f"A flight is a bag or is rendered, not both: leave out the bag {self.bag}, or the conditions."
            )
        if self.label and not _LABEL.fullmatch(self.label):
            raise InvalidInputError(
                "The label of a flight must be 1 to 40 of the letters a to z and A to Z, digits, '_', '.', '+' and "
                f"'-', and begin with a letter or digit, got {shown(self.label)}."
            )

    @classmethod
    def of(cls, conditions: Mapping[str, object]) -> "FlightSpec":
        """Return the flight that a mapping describes, such as a scenario's `flight`: `bag`, or some conditions.

        Raises:
            InvalidInputError: a key is unknown, or a value is of another type or out of range.

        >>> FlightSpec.of({"town": 8, "height": 80}).conditions()
        {'town': 8, 'height': 80.0}
        """
        for key in conditions:
            if key not in KEYS:
                raise InvalidInputError(
                    f"A flight has no {shown(key)}: {suggestion(key, KEYS)}name some of {', '.join(KEYS)}."
                )
        values: dict[str, Any] = dict(conditions)
        if isinstance(bag := values.get("bag"), str):
            if not bag.strip() or "\0" in bag:
                raise InvalidInputError(f"The bag of a flight must be a path, got {shown(bag)}.")
            values["bag"] = Path(bag)
        return cls(**values)

    def conditions(self) -> dict[str, int | float | str]:
        """Return the argument of `of`, without the values of the default flight; a path as a text."""
        return self._changed() if self.bag is None else {"bag": str(self.bag)}

    def _changed(self) -> dict[str, int | float | str]:
        values = {name: getattr(self, name) for name in _DEFAULTS}
        return {name: value for name, value in values.items() if value != _DEFAULTS[name]}

    @property
    def name(self) -> str:
        """Its name in tables and records: its label, or its bag or conditions in short."""
        if self.label:
            return self.label
        if self.bag is not None:
            return self.bag.stem or self.bag.resolve().stem
        if not self.conditions():
            return "default"
        seed = f"-seed{self.seed}" if self.seed else ""
        return f"town{self.town}-{self.height:g}m-{self.angle:g}deg-{self.time}-{self.weather}{seed}"


def parse_flights(texts: Sequence[str]) -> tuple[FlightSpec, ...]:
    """Return the flights of these names: `default`, `panel`, a flight of the panel, or a bag's path.

    `LABEL=` before a path is the flight's name.

    Raises:
        InvalidInputError: a flight is unknown, or two have the same name.

    >>> [flight.name for flight in parse_flights(["default", "night=over/town.mcap"])]
    ['default', 'night']
    """
    known = {"default": (FlightSpec(),), "panel": PANEL} | {flight.name: (flight,) for flight in PANEL}
    flights = tuple(flight for text in texts for flight in known.get(text) or (_parse_bag(text, known),))
    names = [flight.name for flight in flights]
    if len(set(names)) < len(names):
        raise InvalidInputError(
            f"Each flight must be named once, got {', '.join(names)}; LABEL=PATH gives a bag another name."
        )
    return flights


def _parse_bag(text: str, known: Collection[str]) -> FlightSpec:
    label, separator, path = text.partition("=")
    if not separator or "/" in label:
        label, path = "", text
    if label in known:
        raise InvalidInputError(
            f"The label {label} is the name of another flight; call {shown(path)} something else."
        )
    if not path or "\0" in path or not ("/" in path or Path(path).suffix or Path(path).exists()):
        raise InvalidInputError(
            f"There is no flight {shown(text)}: {suggestion(text, known)}name default, panel, one of the panel "
            f"({', '.join(flight.name for flight in PANEL)}), or the path of a bag."
        )
    return FlightSpec(bag=Path(path), label=label)


KEYS: Final = tuple(field.name for field in fields(FlightSpec) if field.name != "label")
"""The keys of a mapping that describes a flight."""
_DEFAULTS: Final = {field.name: field.default for field in fields(FlightSpec) if field.name in KEYS[1:]}

HELD_OUT: Final = (
    FlightSpec(town=8, height=35, angle=45, time="noon", weather="clear"),
    FlightSpec(town=8, height=65, angle=75, time="evening", weather="overcast"),
    FlightSpec(town=1, height=110, angle=75, time="morning", weather="hazy"),
    FlightSpec(town=1, height=65, angle=45, time="evening", weather="clear"),
)
"""Flights whose towns, heights and angles were not used for training or calibration of a shipped model."""

PANEL: Final = (
    FlightSpec(town=2, height=20, angle=30, time="morning", weather="clear"),
    FlightSpec(town=3, height=50, angle=60, time="noon", weather="overcast"),
    FlightSpec(town=5, height=80, angle=90, time="noon", weather="hazy"),
    FlightSpec(town=6, height=50, angle=60, time="evening", weather="hazy"),
    *HELD_OUT,
)
"""The flights for comparing managing systems: various towns, heights, angles, times of day and weathers."""

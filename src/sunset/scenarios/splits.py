"""Scenarios drawn at random for training, validation and two kinds of tests, which never share a scenario.

`train` and `validation` are drawn from the same parts; a scenario's faults decide to which of the two it belongs. The
parts of `test` differ: pairs of faults, a profile, severities, and the towns, heights and weathers of flights. Each
scenario of `wild` has a fault that no catalogue lists.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import floor
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeVar

import msgspec
from msgspec import Meta

from sunset.errors import InvalidInputError, ScenarioError
from sunset.files.inputs import read_bytes
from sunset.files.outputs import draft_of_folder
from sunset.files.schemas import check_fields, convert, document_text, read_json
from sunset.flights import TIMES, FlightSpec
from sunset.scenarios.schema import INTERMITTENT, RAMP, STEP, After, Profile, Scenario, ScenarioFault
from sunset.system import current_system, excluding_pairs, get_fault, loaded_extensions, unlisted_names
from sunset_ros.seeding import check_seed, generator
from sunset_ros.texts import shown, suggestion

if TYPE_CHECKING:
    import numpy as np

TRAIN: Final = "train"
VALIDATION: Final = "validation"
TEST: Final = "test"
WILD: Final = "wild"
SPLITS: Final[tuple[str, ...]] = (TRAIN, VALIDATION, TEST, WILD)

RULE: Final = 1
"""The rule of drawing, increased whenever the same specification would give another split."""

SPLIT_FILE: Final = "split.json"

_SHORTEST_SALT: Final = 16
"""Bytes; a shorter salt could be guessed, since its SHA-256 is published."""
MAX_BYTES: Final = 1_000_000
"""Of a scenario file, or a salt."""

_ANGLES: Final = (30.0, 60.0, 90.0)
_LATEST_S: Final = 12.0
"""Onsets are drawn up to here, so that there is time to repair within the 20 s of a scenario."""
_HEALING: Final = 0.4
"""Share of the faults that heal."""
_FOLLOWING: Final = 0.3
"""Share of the scenarios in which a fault follows another, among those in which that is possible."""
_SHARE: Final = 4
"""A fourth of the scenarios that `train` could have belongs to `validation`."""


@dataclass(frozen=True, slots=True)
class Parts:
    """The values that the scenarios of a split are drawn from.

    Attributes:
        counts: numbers of faults in a scenario.
        profiles: kinds of profiles; a fault without a strength cannot have a ramp.
        severities: of faults that degrade images and have a strength.
    """

    counts: tuple[int, ...]
    profiles: tuple[str, ...]
    severities: tuple[int, ...]
    towns: tuple[int, ...]
    heights: tuple[float, ...]
    weathers: tuple[str, ...]


_KNOWN: Final = Parts(
    (1, 2, 3), (STEP, RAMP), (1, 3), (1, 2, 3, 4, 5, 6), (20.0, 50.0, 80.0), ("clear", "overcast")
)
_NEW: Final = Parts((2, 3), (STEP, RAMP, INTERMITTENT), (2,), (7, 8), (35.0, 65.0), ("hazy",))
_UNLISTED: Final = replace(_NEW, counts=(1, 2))
PARTS: Final = {TRAIN: _KNOWN, VALIDATION: _KNOWN, TEST: _NEW, WILD: _UNLISTED}
"""Split → its parts. Every scenario of `test` has an intermittent fault, every scenario of `wild` an unlisted fault."""


def held_out_pairs() -> frozenset[frozenset[str]]:
    """Return the pairs of faults that are together in `test` only, in each of its scenarios.

    Their numbers in the catalogue, counted from 0, add up to a multiple of 3: about a third of all pairs.

    >>> frozenset({"camera_driver_issue", "memory_leakage"}) in held_out_pairs()
    True
    """
    system = current_system()
    numbered = combinations(enumerate(system.faults), 2)
    pairs = {
        frozenset({name, other}) for (first, name), (second, other) in numbered if (first + second) % 3 == 0
    }
    return frozenset(pairs - set(map(frozenset, system.exclusive)))


@dataclass(frozen=True, kw_only=True)
class SplitSpec:
    """The specification of a split.

    Attributes:
        split: one of `SPLITS`.
        count: the number of scenarios.
        seed: the seed of all draws.
        flights: whether each scenario has a flight of its own, instead of the default flight.
        salt: a secret that the draws also depend on, for a split that stays sealed.

    Raises:
        InvalidInputError: a value is of another type or out of range.
    """

    split: str
    count: Annotated[int, Meta(ge=1, le=9999, title="number of scenarios")]
    seed: int = 0
    flights: bool = False
    salt: bytes = b""

    def __post_init__(self) -> None:
        check_fields(self)
        check_seed(self.seed)
        if self.split not in SPLITS:
            raise InvalidInputError(
                f"There is no split {shown(self.split)}: {suggestion(self.split, SPLITS)}choose one of "
                f"{', '.join(SPLITS)}."
            )


def draw_split(spec: SplitSpec) -> tuple[Scenario, ...]:
    """Return the scenarios of a split: the same for the same specification, catalogue of faults and `RULE`.

    >>> [scenario.name for scenario in draw_split(SplitSpec(split="train", count=2))]
    ['train-0001', 'train-0002']
    """
    draw = _Draw(generator(spec.seed, "split", spec.split, spec.salt.hex()))
    drawn: dict[str, Scenario] = {}
    causes = unlisted_names(sealed=bool(spec.salt)) if spec.split == WILD else ()
    while len(drawn) < spec.count:
        faults = draw.faults(PARTS[spec.split], held_out_pairs(), causes, is_test=spec.split == TEST)
        course = json.dumps([fault.to_mapping() for fault in faults])
        if course in drawn or (spec.split in {TRAIN, VALIDATION} and spec.split != _owner(course)):
            continue
        flight = draw.flight(PARTS[spec.split]) if spec.flights else None
        drawn[course] = Scenario(f"{spec.split}-{len(drawn) + 1:04}", faults, flight=flight)
    return tuple(drawn.values())


def _owner(course: str) -> str:
    """Return the split, `train` or `validation`, of a scenario with these faults."""
    return TRAIN if hashlib.sha256(course.encode()).digest()[0] % _SHARE else VALIDATION


_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class _Draw:
    """Draws by numbers in [0, 1) only, since other draws of a generator may change with NumPy's version."""

    rng: "np.random.Generator"

    def item(self, items: Sequence[_T]) -> _T:
        return items[floor(self.rng.random() * len(items))]

    def seconds(self, low: float, high: float) -> float:
        """Return tenths of seconds in [low, high)."""
        return floor((low + self.rng.random() * (high - low)) * 10) / 10

    def flight(self, parts: Parts) -> FlightSpec:
        return FlightSpec(
            town=self.item(parts.towns),
            height=self.item(parts.heights),
            angle=self.item(_ANGLES),
            time=self.item(TIMES),
            weather=self.item(parts.weathers),
        )

    def faults(
        self, parts: Parts, new: frozenset[frozenset[str]], causes: Sequence[str] = (), *, is_test: bool
    ) -> tuple[ScenarioFault, ...]:
        """Return the faults of a scenario, in the order in which they come."""
        count = self.item(parts.counts)
        while True:
            names = self._names(count, causes)
            pairs = {frozenset(pair) for pair in combinations(names, 2)}
            fits = bool(causes) or bool(pairs & new) == is_test
            if fits and not pairs & set(map(frozenset, excluding_pairs())):
                break
        profiles = [self._profile(name, parts.profiles) for name in names]
        if is_test and INTERMITTENT not in {profile.kind for profile in profiles}:
            profiles[0] = self._intermittent()
        faults = [self._fault(name, profile, parts) for name, profile in zip(names, profiles, strict=True)]
        return self._linked(sorted(faults, key=lambda fault: fault.at))

    def _names(self, count: int, causes: Sequence[str]) -> list[str]:
        """Return different faults, the first of them from `causes`, if any."""
        known, first = list(current_system().faults), [self.item(causes)] if causes else []
        return first + [known.pop(floor(self.rng.random() * len(known))) for _ in range(count - len(first))]

    def _profile(self, name: str, kinds: Sequence[str]) -> Profile:
        kind = self.item(kinds)
        if kind == INTERMITTENT:
            return self._intermittent()
        if kind == RAMP and get_fault(name).limits is not None:
            return Profile(kind=RAMP, rise=self.seconds(2, 6))
        return Profile()

    def _intermittent(self) -> Profile:
        return Profile(kind=INTERMITTENT, on=self.seconds(1.5, 4), off=self.seconds(1.5, 4))

    def _fault(self, name: str, profile: Profile, parts: Parts) -> ScenarioFault:
        described = get_fault(name)
        measured = described.limits is not None and described.effect is not None
        at, lasts, heals = self.seconds(0, _LATEST_S), self.seconds(2, 8), self.rng.random() < _HEALING
        severity = self.item(parts.severities) if measured else None
        return ScenarioFault(
            name, at=at, until=round(at + lasts, 1) if heals else None, profile=profile, severity=severity
        )

    def _linked(self, faults: list[ScenarioFault]) -> tuple[ScenarioFault, ...]:
        """Let the last fault sometimes follow the first, if that stays until it is cured."""
        first, last = faults[0], faults[-1]
        delay, follows = self.seconds(3, 6), self.rng.random() < _FOLLOWING
        if follows and len(faults) > 1 and first.until is None and first.profile.kind != INTERMITTENT:
            after = After(fault=first.name, delay=delay)
            faults[-1] = replace(last, at=0.0, until=None, after=after)
        return tuple(faults)


class SplitDescription(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `split.json`: a split's specification, and the hash by which it is pinned.

    Attributes:
        salt_sha256: the salt's hash, in hexadecimal; None without a salt.
        rule: the rule of drawing.
        extensions: of the managed system: name → checksum.
        sha256: of the lines that `sha256sum *.yaml` prints for the scenario files.
    """

    split: str
    count: int
    seed: int
    flights: bool
    salt_sha256: str | None
    rule: int
    extensions: dict[str, str]
    sha256: str


def is_scenario_file(path: Path) -> bool:
    """Return whether a path ends as a scenario file does."""
    return path.suffix.lower() in {".yaml", ".yml"}


def scenario_files(folder: Path) -> list[Path]:
    """Return the scenario files of a folder, in their order."""
    return sorted(filter(is_scenario_file, folder.iterdir()))


def read_salt(file: Path) -> bytes:
    """Return the salt of a split, all bytes of a file."""
    try:
        salt = read_bytes(file, MAX_BYTES)
    except OSError as error:
        raise InvalidInputError(f"The salt {file} cannot be read: {error.strerror}.") from error
    if len(salt) < _SHORTEST_SALT:
        raise InvalidInputError(
            f"The salt {file} must have at least {_SHORTEST_SALT} bytes, or it can be guessed, got {len(salt)}; "
            "'openssl rand -hex 32' prints one."
        )
    return salt


def write_split(spec: SplitSpec, folder: Path) -> SplitDescription:
    """Draw a split and write it into a new folder, all of it or nothing."""
    described, files = _drawn(spec)
    with draft_of_folder(folder, "split") as draft:
        for name, content in files.items():
            (draft / name).write_bytes(content)
        (draft / SPLIT_FILE).write_text(document_text(described), encoding="utf-8")
    return described


def read_split(folder: Path) -> SplitDescription | None:
    """Return the content of a folder's `split.json`; None without this file.

    Raises:
        ScenarioError: it is damaged, or the scenario files have another hash.
    """
    place = folder / SPLIT_FILE
    if not place.exists():
        return None
    remedy = "generate the split again"
    content = read_json(place, "The file", ScenarioError)
    described = convert(content, SplitDescription, str(place), ScenarioError, remedy=remedy)
    try:
        files = {file.name: read_bytes(file, MAX_BYTES) for file in scenario_files(folder)}
    except OSError as error:
        raise ScenarioError(f"The split {folder} cannot be read: {error.strerror}.") from error
    if _digest(files) != described.sha256:
        raise ScenarioError(
            f"The scenarios in {folder} are not those of its {SPLIT_FILE}: {remedy}, or remove {SPLIT_FILE} to use "
            "them as scenarios of your own."
        )
    return described


def check_split(folder: Path, salt: bytes = b"") -> SplitDescription:
    """Draw the split of a folder again, from its `split.json`, and compare the scenarios.

    Args:
        folder: a folder by `write_split`.
        salt: of the split; the folder does not contain it.

    Raises:
        ScenarioError: the folder is not a split, is damaged, or has other scenarios than are drawn.
        InvalidInputError: the salt is missing or wrong.
    """
    described = read_split(folder)
    if described is None:
        raise ScenarioError(
            f"There is no {SPLIT_FILE} in {folder}: name a folder that 'sunset scenarios generate --split' wrote."
        )
    spec = SplitSpec(
        split=described.split,
        count=described.count,
        seed=described.seed,
        flights=described.flights,
        salt=salt,
    )
    expected, _ = _drawn(spec)
    if described.salt_sha256 != expected.salt_sha256:
        remedy = "name its file with --salt-file" if described.salt_sha256 else "leave --salt-file out"
        raise InvalidInputError(
            f"The split in {folder} was made with {_salt_text(described)}, got {_salt_text(expected)}: {remedy}."
        )
    if described != expected:
        raise ScenarioError(f"The split in {folder} {_difference(described, expected)}.")
    return described


def _difference(described: SplitDescription, expected: SplitDescription) -> str:
    if described.extensions != expected.extensions:
        named = ", ".join(described.extensions) or "none"
        return f"was made with other extensions ({named}), or other versions of them: name these with --extension"
    return f"does not have the scenarios that its {SPLIT_FILE} makes"


def _salt_text(described: SplitDescription) -> str:
    return f"a salt of the SHA-256 {described.salt_sha256}" if described.salt_sha256 else "no salt"


def _drawn(spec: SplitSpec) -> tuple[SplitDescription, dict[str, bytes]]:
    """Return the description of a split, and its scenario files."""
    files = {f"{scenario.name}.yaml": scenario.to_yaml().encode() for scenario in draw_split(spec)}
    described = SplitDescription(
        split=spec.split,
        count=spec.count,
        seed=spec.seed,
        flights=spec.flights,
        salt_sha256=hashlib.sha256(spec.salt).hexdigest() if spec.salt else None,
        rule=RULE,
        extensions={extension.name: extension.checksum for extension in loaded_extensions()},
        sha256=_digest(files),
    )
    return described, files


def _digest(files: Mapping[str, bytes]) -> str:
    """Return the SHA-256 over the lines that `sha256sum *.yaml` prints of files, in hexadecimal."""
    lines = (f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in sorted(files.items()))
    return hashlib.sha256("".join(lines).encode()).hexdigest()

"""A split as a folder: a file for each scenario, and a description with their hash."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import msgspec

from sunset.errors import InvalidInputError, ScenarioError
from sunset.files.inputs import read_bytes
from sunset.files.outputs import draft_of_folder
from sunset.files.schemas import convert, document_text, read_json
from sunset.scenarios.splits import RULE, SplitSpec, draw_split
from sunset.system import loaded_extensions

SPLIT_FILE: Final = "split.json"

_SHORTEST_SALT: Final = 16
"""Bytes; a shorter salt could be guessed, since its SHA-256 is published."""
_MAX_BYTES: Final = 1_000_000


class SplitDescription(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `split.json`: how a split was drawn, and the hash by which it is pinned.

    Attributes:
        split: train, validation, test or wild.
        count: the number of scenarios.
        seed: the seed of all draws.
        flights: whether each scenario has a flight of its own.
        salt_sha256: the salt's hash, in hexadecimal; None without a salt.
        rule: the rule of drawing.
        extensions: of the managed system: name → checksum.
        sha256: over the scenario files, as of the lines that `sha256sum *.yaml` prints.
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
        salt = read_bytes(file, _MAX_BYTES)
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
    files = _draw_files(spec)
    described = _describe(spec, files)
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
        files = {file.name: read_bytes(file, _MAX_BYTES) for file in scenario_files(folder)}
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
    expected = _describe(spec, _draw_files(spec))
    if described.salt_sha256 != expected.salt_sha256:
        remedy = "name its file with --salt-file" if described.salt_sha256 else "leave --salt-file out"
        raise InvalidInputError(
            f"The split in {folder} was made with {_salt_text(described)}, got {_salt_text(expected)}: {remedy}."
        )
    if described != expected:
        raise ScenarioError(f"The split in {folder} {_difference(described, expected)}.")
    return described


def _difference(described: SplitDescription, expected: SplitDescription) -> str:
    if described.rule != expected.rule:
        return (
            f"was drawn by rule {described.rule}, and this version draws by rule {RULE}: use another version"
        )
    if described.extensions != expected.extensions:
        named = ", ".join(described.extensions) or "none"
        return f"was made with other extensions ({named}), or other versions of them: name these with --extension"
    return f"does not have the scenarios that its {SPLIT_FILE} makes"


def _salt_text(described: SplitDescription) -> str:
    return f"a salt of the SHA-256 {described.salt_sha256}" if described.salt_sha256 else "no salt"


def _draw_files(spec: SplitSpec) -> dict[str, bytes]:
    return {f"{scenario.name}.yaml": scenario.to_yaml().encode() for scenario in draw_split(spec)}


def _describe(spec: SplitSpec, files: Mapping[str, bytes]) -> SplitDescription:
    return SplitDescription(
        split=spec.split,
        count=spec.count,
        seed=spec.seed,
        flights=spec.flights,
        salt_sha256=hashlib.sha256(spec.salt).hexdigest() if spec.salt else None,
        rule=RULE,
        extensions={extension.name: extension.checksum for extension in loaded_extensions()},
        sha256=_digest(files),
    )


def _digest(files: Mapping[str, bytes]) -> str:
    """Return the SHA-256 over the lines that `sha256sum *.yaml` prints of files, in hexadecimal."""
    lines = (f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in sorted(files.items()))
    return hashlib.sha256("".join(lines).encode()).hexdigest()

"""A split as a folder: a file for each scenario, and what they were made of and are pinned by."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import msgspec

from sunset.errors import InvalidInputError, ScenarioError
from sunset.input_files import read_bytes
from sunset.output_files import draft_of_folder
from sunset.scenarios.splits import RULE, SplitSpec, draw_split
from sunset.schemas import convert, document_text, read_json
from sunset.system import loaded_extensions

SPLIT_FILE: Final = "split.json"

_SUFFIXES: Final = frozenset({".yaml", ".yml"})
_SHORTEST_SALT: Final = 16
"""Bytes; a shorter salt could be found by trying, since its SHA-256 is published."""
_LONGEST: Final = 1_000_000


class SplitDescription(msgspec.Struct, frozen=True, kw_only=True):
    """What `split.json` says: what a split was made of, and the hash by which it is pinned.

    Attributes:
        split: train, validation, test or wild.
        count: how many scenarios it has.
        seed: of everything that is drawn.
        flights: whether each scenario has a flight of its own.
        salt_sha256: of the salt, in hexadecimal; None if there is none.
        rule: by which it was drawn.
        extensions: of the system's description: name → checksum.
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
    """Return whether a path is named as a scenario file is."""
    return path.suffix.lower() in _SUFFIXES


def scenario_files(folder: Path) -> list[Path]:
    """Return the scenario files of a folder, in their order.

    Raises:
        OSError: it cannot be read.
    """
    return sorted(filter(is_scenario_file, folder.iterdir()))


def read_salt(file: Path) -> bytes:
    """Return the salt of a split, all bytes of a file.

    Raises:
        InvalidInputError: the file cannot be read, or is too short or too long.
    """
    try:
        salt = read_bytes(file, _LONGEST)
    except OSError as error:
        raise InvalidInputError(f"The salt {file} cannot be read: {error.strerror}.") from error
    if len(salt) < _SHORTEST_SALT:
        raise InvalidInputError(
            f"The salt {file} must have at least {_SHORTEST_SALT} bytes, so that nobody can guess it, got {len(salt)}; "
            "'openssl rand -hex 32' prints one."
        )
    return salt


def write_split(spec: SplitSpec, folder: Path) -> SplitDescription:
    """Write the scenarios of a split into a new folder, with what they were made of, all of it or nothing.

    Raises:
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    texts = _texts(spec)
    described = _describe(spec, texts)
    with draft_of_folder(folder, "split") as draft:
        for name, text in texts.items():
            (draft / name).write_text(text, encoding="utf-8")
        (draft / SPLIT_FILE).write_text(document_text(described), encoding="utf-8")
    return described


def read_split(folder: Path) -> SplitDescription | None:
    """Return what the `split.json` of a folder says; None if it has none.

    Raises:
        ScenarioError: it is damaged, or the scenario files are not those that it was written with.
    """
    place = folder / SPLIT_FILE
    if not place.exists():
        return None
    remedy = "generate the split anew"
    described = convert(
        read_json(place, "The file", ScenarioError),
        SplitDescription,
        str(place),
        ScenarioError,
        remedy=remedy,
    )
    try:
        files = {file.name: read_bytes(file, _LONGEST) for file in scenario_files(folder)}
    except OSError as error:
        raise ScenarioError(f"The split {folder} cannot be read: {error.strerror}.") from error
    if _digest(files) != described.sha256:
        raise ScenarioError(
            f"The scenarios in {folder} are not those of its {SPLIT_FILE}: {remedy}, or remove {SPLIT_FILE} to use "
            "them as scenarios of your own."
        )
    return described


def check_split(folder: Path, salt: bytes = b"") -> SplitDescription:
    """Generate the split of a folder anew, from what its `split.json` says, and compare the scenarios.

    Args:
        folder: that was written with `write_split`.
        salt: of the split, which the folder has no copy of.

    Raises:
        ScenarioError: there is no split, it is damaged, or its scenarios are not those that are generated.
        InvalidInputError: the salt is missing or is another one.
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
    expected = _describe(spec, texts := _texts(spec))
    if described.salt_sha256 != expected.salt_sha256:
        made = f"a salt of the SHA-256 {described.salt_sha256}" if described.salt_sha256 else "no salt"
        got = f"one of {expected.salt_sha256}" if expected.salt_sha256 else "none"
        remedy = "name its file with --salt-file" if described.salt_sha256 else "leave --salt-file out"
        raise InvalidInputError(f"The split in {folder} was made with {made}, got {got}: {remedy}.")
    if described.rule != RULE:
        raise ScenarioError(
            f"The split in {folder} was drawn by rule {described.rule}, and this version draws by rule {RULE}; "
            "check it with the version that it was made with."
        )
    if described.extensions != expected.extensions:
        named = ", ".join(described.extensions) or "none"
        raise ScenarioError(
            f"The split in {folder} was made with other extensions ({named}), or with others of these names: name the "
            "same ones with --extension."
        )
    if described != expected:
        raise ScenarioError(
            f"The scenarios in {folder} are not those that its {SPLIT_FILE} makes{_first(folder, texts)}."
        )
    return described


def _first(folder: Path, texts: Mapping[str, str]) -> str:
    """Return in words which is the first scenario file of a folder that differs; nothing if none does."""
    there = {file.name: file.read_bytes() for file in scenario_files(folder)}
    names = sorted({*there, *texts})
    differing = (name for name in names if there.get(name) != texts.get(name, "").encode())
    name = next(differing, "")
    return f": {name} differs" if name else ""


def _texts(spec: SplitSpec) -> dict[str, str]:
    """Return the scenario files of a split by name, in their order."""
    return {f"{scenario.name}.yaml": scenario.to_yaml() for scenario in draw_split(spec)}


def _describe(spec: SplitSpec, texts: Mapping[str, str]) -> SplitDescription:
    return SplitDescription(
        split=spec.split,
        count=spec.count,
        seed=spec.seed,
        flights=spec.flights,
        salt_sha256=hashlib.sha256(spec.salt).hexdigest() if spec.salt else None,
        rule=RULE,
        extensions={one.name: one.checksum for one in loaded_extensions()},
        sha256=_digest({name: text.encode() for name, text in texts.items()}),
    )


def _digest(files: Mapping[str, bytes]) -> str:
    """Return the SHA-256 over the lines that `sha256sum *.yaml` prints of files, in hexadecimal."""
    lines = (f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in sorted(files.items()))
    return hashlib.sha256("".join(lines).encode()).hexdigest()

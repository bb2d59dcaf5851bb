"""Scenarios drawn for training, validation and test, as folders of files."""

from pathlib import Path

from sunset.api.arguments import Extensions, as_path, extended, whole_of
from sunset.scenarios import SPLITS, SplitDescription, SplitSpec, read_salt, write_split
from sunset.scenarios import check_split as check_folder

__all__ = ["SPLITS", "SplitDescription", "check_split", "generate_split"]


def generate_split(
    split: str,
    count: int,
    out: str | Path,
    *,
    seed: int = 0,
    flights: bool = False,
    salt_file: str | Path | None = None,
    extensions: Extensions = (),
) -> SplitDescription:
    """Write scenarios for training, validation or test into a folder, as `sunset scenarios generate --split` does.

    Args:
        split: `train`, `validation`, `test` or `wild`; they never share a scenario.
        count: how many scenarios, from 1 to 9999; a smaller split is the beginning of a larger split.
        out: the folder, which must not exist, or be empty.
        seed: of everything that is drawn.
        flights: whether each scenario has a flight of its own, in place of the default flight.
        salt_file: a file with a secret that the draws depend on besides.
        extensions: of the managed system, whose faults are drawn, too.

    Returns:
        The content of the folder's `split.json`; `sha256` pins the scenarios.

    Raises:
        InvalidInputError: the split is unknown, a number is out of range, or the salt is not usable.
        OutputError: the folder is not empty, or cannot be written.
    """
    folder, salt = as_path(out, "folder of the split"), _salt(salt_file)
    with extended(extensions):
        spec = SplitSpec(split=split, count=whole_of(count), seed=whole_of(seed), flights=flights, salt=salt)
        return write_split(spec, folder)


def check_split(
    folder: str | Path, *, salt_file: str | Path | None = None, extensions: Extensions = ()
) -> SplitDescription:
    """Generate the split of a folder again and compare the scenarios, as `sunset scenarios check` does.

    Args:
        folder: the folder that `generate_split` has written.
        salt_file: the file with the secret of the split.
        extensions: those that the split was generated with.

    Returns:
        The content of the folder's `split.json`.

    Raises:
        ScenarioError: the folder is not a split, or its scenarios differ from the generated scenarios.
        InvalidInputError: the salt is missing or wrong.
    """
    place, salt = as_path(folder, "folder of the split"), _salt(salt_file)
    with extended(extensions):
        return check_folder(place, salt)


def _salt(file: str | Path | None) -> bytes:
    return b"" if file is None else read_salt(as_path(file, "salt's file"))

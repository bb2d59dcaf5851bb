"""Shards: parts of a campaign that are run separately, such as by the jobs of an array; and the campaign's lock."""

import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeVar

from sunset.errors import InvalidInputError, OutputError
from sunset.files.outputs import make_folder
from sunset.texts.names import PLAN_FILE
from sunset.texts.sentences import counted
from sunset_ros.texts import shown

_Item = TypeVar("_Item")

_LOCK_FILE: Final = ".lock"
_SHARD: Final = re.compile(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})")


@dataclass(frozen=True, slots=True)
class Shard:
    """Part `number`, from 1 on, of the `count` parts that a campaign's runs are split into."""

    number: int
    count: int

    @classmethod
    def parse(cls, text: object) -> "Shard":
        """Return the shard that the text `I/N` names.

        >>> Shard.parse("2/4")
        Shard(number=2, count=4)
        """
        match = _SHARD.fullmatch(text) if isinstance(text, str) else None
        if match is None or int(match[1]) > int(match[2]):
            raise InvalidInputError(
                f"A shard must be I/N, the I-th of N parts, from 1/N to N/N, got {shown(text)}."
            )
        return cls(int(match[1]), int(match[2]))

    def of(self, items: Sequence[_Item]) -> Sequence[_Item]:
        """Return this part of the items: neighbours; the sizes of parts differ by at most 1.

        >>> [Shard(number, 3).of("abcdefgh") for number in (1, 2, 3)]
        ['ab', 'cde', 'fgh']
        """
        total, count = len(items), self.count
        if count > total:
            raise InvalidInputError(f"A campaign of {counted(total, 'run')} cannot have {count} shards.")
        return items[total * (self.number - 1) // count : total * self.number // count]


@contextmanager
def locked_campaign(out: Path, shard: Shard | None = None) -> Iterator[None]:
    """Make a campaign's folder, if there is none, and keep other processes from running the same runs in it."""
    import fcntl  # noqa: PLC0415  not on every system

    make_folder(out)
    beside = (_LOCK_FILE, f".{PLAN_FILE}.")  # another shard may have just begun
    names = [path.name for path in out.iterdir() if not path.name.startswith(beside)]
    if names and not (out / PLAN_FILE).exists():
        raise OutputError(f"The folder {out} is not empty and holds no campaign; name a new folder.")
    locks = {_LOCK_FILE: fcntl.LOCK_SH if shard else fcntl.LOCK_EX}
    if shard:
        locks[f"{_LOCK_FILE}-{shard.number}-of-{shard.count}"] = fcntl.LOCK_EX
    with ExitStack() as files:
        for name, kind in locks.items():
            file = files.enter_context((out / name).open("a+b"))  # network drives need both permissions
            try:
                fcntl.flock(file, kind | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(
                    f"The campaign in {out} is being run by another process: wait for its end, or name another folder."
                ) from error
            except OSError as error:
                raise OutputError(
                    f"The file system of {out} has no locks for files ({error.strerror}), without which two processes "
                    "could write to it: name a folder on another one."
                ) from error
        yield

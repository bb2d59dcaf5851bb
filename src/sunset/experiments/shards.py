"""A part of a campaign that is run for itself, for instance by one job of an array."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

from sunset.errors import InvalidInputError
from sunset.texts import counted, shown

_Item = TypeVar("_Item")

_SHARD: Final = re.compile(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})")


@dataclass(frozen=True, slots=True)
class Shard:
    """One of the parts that a campaign's runs are split in.

    Attributes:
        number: which one, from 1 on.
        count: how many there are.
    """

    number: int
    count: int

    @classmethod
    def parse(cls, text: object) -> "Shard":
        """Return the shard that the text `I/N` names.

        Raises:
            InvalidInputError: the text is not of the form I/N, or there is no such part.

        >>> Shard.parse("2/4")
        Shard(number=2, count=4)
        """
        found = _SHARD.fullmatch(text) if isinstance(text, str) else None
        if found is None or int(found[1]) > int(found[2]):
            raise InvalidInputError(
                f"A shard must be I/N, the I-th of N parts, from 1/N to N/N, got {shown(text)}."
            )
        return cls(int(found[1]), int(found[2]))

    def of(self, items: Sequence[_Item]) -> Sequence[_Item]:
        """Return this part of the items: neighbours, and as many as any other part has, or one more or less.

        Raises:
            InvalidInputError: there are more parts than items.

        >>> [Shard(number, 3).of("abcdefgh") for number in (1, 2, 3)]
        ['ab', 'cde', 'fgh']
        """
        total, count = len(items), self.count
        if count > total:
            raise InvalidInputError(f"A campaign of {counted(total, 'run')} cannot have {count} shards.")
        return items[total * (self.number - 1) // count : total * self.number // count]

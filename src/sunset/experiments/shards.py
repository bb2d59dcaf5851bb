"""Shards: parts of a campaign that are run separately, for instance by the jobs of an array."""

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

"""The limits of a run's numbers, by which stored numbers are checked."""

from typing import Annotated, Final, TypeAlias

from msgspec import Meta

MOST: Final = 10**6
"""The largest number of a run; twelve days for times."""

Share: TypeAlias = Annotated[float, Meta(ge=0, le=1)]
Amount: TypeAlias = Annotated[float, Meta(ge=0, le=MOST)]
Positive: TypeAlias = Annotated[float, Meta(gt=0, le=MOST)]
Count: TypeAlias = Annotated[int, Meta(ge=0, le=MOST)]

"""What the numbers of a run can be at most, so that what is stored of one can be refused."""

from typing import Annotated, Final, TypeAlias

from msgspec import Meta

MOST: Final = 10**6
"""No number of a run is larger; twelve days, of those that are times."""

Share: TypeAlias = Annotated[float, Meta(ge=0, le=1)]
Amount: TypeAlias = Annotated[float, Meta(ge=0, le=MOST)]
Positive: TypeAlias = Annotated[float, Meta(gt=0, le=MOST)]
Count: TypeAlias = Annotated[int, Meta(ge=0, le=MOST)]

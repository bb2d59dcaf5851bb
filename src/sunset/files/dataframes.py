"""Data frames, which need pandas; SUNSET does not install it."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from sunset.errors import MissingExtraError

if TYPE_CHECKING:
    from pandas import DataFrame


def data_frame(rows: Iterable[Mapping[str, object]]) -> "DataFrame":
    """Return rows as a data frame of pandas."""
    try:
        import pandas as pd  # noqa: PLC0415  optional
    except ImportError as error:
        raise MissingExtraError(
            "A data frame needs pandas, which is not installed: 'pip install pandas' installs it; the same figures are "
            "attributes of the object of to_frame."
        ) from error
    return pd.DataFrame(list(rows))

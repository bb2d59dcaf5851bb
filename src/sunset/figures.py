"""What all figures share: their colours, and how they are checked and written."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from sunset.errors import InvalidInputError, MissingExtraError
from sunset.output_files import draft_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE: Final = "#0072B2"
ORANGE: Final = "#D55E00"
"""Both are Okabe and Ito's, which can be told apart with any eyes."""
GREY: Final = "#555555"

_VARYING: Final = {".pdf": "CreationDate", ".png": "Software", ".svg": "Date"}
"""What matplotlib writes beside a drawing that is not the same for the same drawing."""


NEEDS_MATPLOTLIB: Final = (
    'Figures need matplotlib, which is not installed; run: pip install "sunset-exemplar[plots]".'
)


def can_draw() -> bool:
    """Return whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def check_figure(path: Path) -> None:
    """Check what can be checked before there is anything to draw.

    Raises:
        MissingExtraError: matplotlib is not installed.
        InvalidInputError: the path has none of the suffixes `.pdf`, `.png`, `.svg`.
    """
    if not can_draw():
        raise MissingExtraError(NEEDS_MATPLOTLIB)
    if path.suffix.lower() not in _VARYING:
        raise InvalidInputError(f"A figure's file must end in {', '.join(_VARYING)}, got {path}.")


@contextmanager
def drawing(style: Mapping[str, Any] = MappingProxyType({})) -> "Iterator[type[Figure]]":
    """Give matplotlib's class of figures, and ignore the user's settings, so that figures always look the same.

    Args:
        style: what differs from matplotlib's defaults.
    """
    try:
        import matplotlib as mpl  # noqa: PLC0415  an optional extra
    except ValueError:  # a notebook's back end is named, and not installed here
        del os.environ["MPLBACKEND"]
        import matplotlib as mpl  # noqa: PLC0415  see above
    from matplotlib.figure import Figure  # noqa: PLC0415  an optional extra

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(style)
        yield Figure


def save_figure(figure: "Figure", path: Path, *, make_folder: bool = True) -> None:
    """Write a figure, all of it or nothing, and the same bytes for the same drawing; in a context of `drawing`.

    Args:
        figure: of matplotlib.
        path: a `.pdf`, `.png` or `.svg`, which is replaced.
        make_folder: whether its folder is made if it is not there.

    Raises:
        OutputError: the file cannot be written.
    """
    from matplotlib import rc_context  # noqa: PLC0415  an optional extra

    suffix = path.suffix.lower()
    with draft_of(path, "figure") as draft, rc_context({"svg.hashsalt": "sunset", "pdf.fonttype": 42}):
        if make_folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(draft, format=suffix[1:], metadata={_VARYING[suffix]: None})

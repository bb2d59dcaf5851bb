"""Figures by matplotlib: colours, checks, and reproducible files."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from sunset.errors import InvalidInputError, MissingExtraError
from sunset.files.outputs import draft_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE: Final = "#0072B2"
ORANGE: Final = "#D55E00"
"""Both are Okabe and Ito's, which colour-blind readers can distinguish."""
GREY: Final = "#555555"

_VARYING: Final = {".pdf": "CreationDate", ".png": "Software", ".svg": "Date"}
"""Suffix → the metadata of matplotlib that differ between files of the same drawing."""

NEEDS_MATPLOTLIB: Final = (
    'Figures need matplotlib, which is not installed; run: pip install "sunset-exemplar[plots]".'
)


def can_draw() -> bool:
    """Return whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def check_figure(path: Path) -> None:
    """Check that a figure can be drawn, before its data are computed.

    Raises:
        MissingExtraError: matplotlib is not installed.
        InvalidInputError: the path does not end in `.pdf`, `.png` or `.svg`.
    """
    if not can_draw():
        raise MissingExtraError(NEEDS_MATPLOTLIB)
    if path.suffix.lower() not in _VARYING:
        raise InvalidInputError(f"A figure's file must end in {', '.join(_VARYING)}, got {path}.")


@contextmanager
def drawing(style: Mapping[str, object] = MappingProxyType({})) -> "Iterator[type[Figure]]":
    """Give matplotlib's class of figures, without the user's settings, so that figures always look the same.

    Args:
        style: settings that differ from matplotlib's defaults.
    """
    try:
        import matplotlib as mpl  # noqa: PLC0415  an optional extra
    except ValueError:  # MPLBACKEND names a notebook's back end that is not installed here
        del os.environ["MPLBACKEND"]
        import matplotlib as mpl  # noqa: PLC0415  see above
    from matplotlib.figure import Figure  # noqa: PLC0415  an optional extra

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(style)
        yield Figure


def save_figure(figure: "Figure", path: Path, *, make_folder: bool = True) -> None:
    """Write a figure in a context of `drawing`, all of it or nothing; the same drawing gives the same bytes.

    Args:
        figure: the figure.
        path: a `.pdf`, `.png` or `.svg`, which is replaced.
        make_folder: whether to make a missing folder.
    """
    from matplotlib import rc_context  # noqa: PLC0415  an optional extra

    suffix = path.suffix.lower()
    with draft_of(path, "figure") as draft, rc_context({"svg.hashsalt": "sunset", "pdf.fonttype": 42}):
        if make_folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(draft, format=suffix[1:], metadata={_VARYING[suffix]: None})

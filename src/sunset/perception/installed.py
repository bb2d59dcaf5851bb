"""The models that have a name: the package's own, and models that other distributions install.

A distribution offers a model by an entry point of the group `sunset.models`: its name is the model's, its value the
top-level package whose folder holds the card and the networks. That package is not executed.
"""

from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from sunset.errors import ModelError
from sunset.perception.card import CARD_NAME
from sunset_ros.texts import suggestion

OFFERED: Final[Mapping[str, str]] = {"reference": "pip install ./models/reference"}
"""Models of other distributions, and the command that installs each in a clone of SUNSET's repository."""

_GROUP: Final = "sunset.models"
_SHIPPED: Final = Path(__file__).parent / "models"


def list_models() -> tuple[str, ...]:
    """Return the names of the models that are installed, sorted."""
    return tuple(sorted({*_shipped(), *entry_points(group=_GROUP).names}))


def find_model(name: str) -> Path | None:
    """Return the folder of an installed model, or None; the package's own models come first.

    Raises:
        ModelError: several distributions offer the model, or its distribution lacks the files.
    """
    if name in _shipped():
        return _SHIPPED / name
    match list(entry_points(group=_GROUP, name=name)):
        case []:
            return None
        case [point]:
            if (folder := _folder(point)) is None:
                raise ModelError(
                    f"The model {name!r} of the installed distribution {_distribution(point)} is broken: expected the "
                    f"top-level package {point.value!r} with a {CARD_NAME}, found none; install it again."
                )
            return folder
        case points:
            owners = " and ".join(sorted(map(_distribution, points)))
            raise ModelError(
                f"The model {name!r} is offered by several installed distributions, {owners}: uninstall all but one."
            )


def missing_model_error(name: str) -> ModelError:
    """Return the error for a name of neither an installed model nor a folder."""
    if name in OFFERED:
        return ModelError(
            f"The model {name!r} is not installed: in a clone of SUNSET's repository, run {OFFERED[name]!r}."
        )
    installed = list_models()
    hint = suggestion(name, (*installed, *OFFERED))
    return ModelError(
        f"There is no model {name!r}: {hint}name a folder with a {CARD_NAME} or one of {', '.join(installed)}."
    )


def is_installed(folder: Path) -> bool:
    """Return whether a folder holds an installed model, which only installers change."""
    shipped = (_SHIPPED / name for name in _shipped())
    others = (_folder(point) for point in entry_points(group=_GROUP))
    return folder.resolve() in {place.resolve() for place in (*shipped, *others) if place is not None}


def _shipped() -> list[str]:
    return [path.parent.name for path in _SHIPPED.glob(f"*/{CARD_NAME}")]


def _folder(point: EntryPoint) -> Path | None:
    """Return the folder that an entry point names, if it has a card."""
    try:
        # of a name with dots, the parent packages would be imported
        spec = find_spec(point.value) if point.value.isidentifier() else None
    except (ImportError, ValueError):
        return None
    places = map(Path, (spec and spec.submodule_search_locations) or ())
    return next((place for place in places if (place / CARD_NAME).is_file()), None)


def _distribution(point: EntryPoint) -> str:
    return repr(point.dist.name if point.dist else "?")

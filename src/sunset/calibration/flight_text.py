"""What a model makes of flights, as tables of text."""

from collections.abc import Callable, Collection, Iterator, Mapping

from sunset.calibration.flight import AUC, CURED, MISSED, OF_CARD, OVER, FlightThresholds
from sunset.tables import aligned
from sunset.texts import listed


def as_text(model: str, found: Mapping[str, FlightThresholds], held_out: Collection[str]) -> str:
    """Return tables of at least one flight: thresholds, healthy windows over them, and each fault and its cure.

    Args:
        model: its name.
        found: flight → its thresholds.
        held_out: the names of flights that no training and no calibration has seen.
    """
    parts = [
        "\n".join(aligned([("flight", "held out", "entropy", "sharpness"), *_thresholds(found, held_out)])),
        _table("windows without a fault over the threshold, by network", found, lambda one: one.over),
        _table("AUC of the entropy, by fault", found, lambda one: one.auc),
        _table("windows with a fault that are not over the threshold", found, lambda one: one.missed),
        _table("windows after the cheapest cure that are not over it", found, lambda one: one.cured),
        "\n".join(_verdicts(model, found)),
    ]
    return "\n\n".join(parts) + "\n"


def _thresholds(
    found: Mapping[str, FlightThresholds], held_out: Collection[str]
) -> Iterator[tuple[str, ...]]:
    for name, one in found.items():
        unseen = "yes" if name in held_out else "no"
        yield name, unseen, f"{one.entropy_threshold:.4f}", f"{one.sharpness_threshold:.4f}"


def _table(
    title: str,
    found: Mapping[str, FlightThresholds],
    shares: Callable[[FlightThresholds], Mapping[str, float]],
) -> str:
    names = list(dict.fromkeys(name for one in found.values() for name in shares(one)))
    rows = [
        (flight, *(f"{shares(one)[name]:.3f}" if name in shares(one) else "N/A" for name in names))
        for flight, one in found.items()
    ]
    return "\n".join([f"{title}:", *aligned([("flight", *names), *rows])])


def _verdicts(model: str, found: Mapping[str, FlightThresholds]) -> Iterator[str]:
    """Yield what must hold on each flight, and where it does not."""
    yield (
        f"On each flight at most {OVER:.0%} of the windows without a fault should be over the threshold, the AUC of "
        f"each fault {AUC} or more, at most {MISSED:.0%} of the windows with it not over the threshold, and "
        f"{CURED:.0%} or more of those after its cure."
    )
    own = [flight for flight, one in found.items() if OF_CARD in one.made_of]
    if own:
        yield (
            f"On {listed(own)} runs have the thresholds of the model's card, which were not found on this flight."
        )
    beyond = {flight: one.shortfalls() for flight, one in found.items() if one.shortfalls()}
    for flight, texts in beyond.items():
        yield f"Beyond {model} is {flight}: {listed(texts)}."
    if not beyond:
        yield f"All of it holds for {model}."

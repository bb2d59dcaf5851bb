"""The thresholds of a model on flights, and their quality, as text."""

from collections.abc import Callable, Collection, Iterator, Mapping

from sunset.calibration.flight import AUC, CURED, MISSED, OF_CARD, OVER, FlightThresholds
from sunset.texts.sentences import listed
from sunset.texts.tables import aligned


def flights_text(model: str, flights: Mapping[str, FlightThresholds], held_out: Collection[str]) -> str:
    """Return tables of thresholds, of healthy windows above them, and of each fault and its cure.

    Args:
        model: its name.
        flights: flight → its thresholds; at least one.
        held_out: the names of flights that neither a training nor a calibration used.
    """
    parts = [
        "\n".join(aligned([("flight", "held out", "entropy", "sharpness"), *_thresholds(flights, held_out)])),
        _table("windows without a fault over the threshold, by network", flights, lambda each: each.over),
        _table("AUC of the entropy, by fault", flights, lambda each: each.auc),
        _table("windows with a fault that are not over the threshold", flights, lambda each: each.missed),
        _table("windows after the cheapest cure that are not over it", flights, lambda each: each.cured),
        "\n".join(_verdicts(model, flights)),
    ]
    return "\n\n".join(parts) + "\n"


def _thresholds(
    flights: Mapping[str, FlightThresholds], held_out: Collection[str]
) -> Iterator[tuple[str, ...]]:
    for name, each in flights.items():
        unseen = "yes" if name in held_out else "no"
        yield name, unseen, f"{each.entropy_threshold:.4f}", f"{each.sharpness_threshold:.4f}"


def _table(
    title: str,
    flights: Mapping[str, FlightThresholds],
    shares: Callable[[FlightThresholds], Mapping[str, float]],
) -> str:
    names = list(dict.fromkeys(name for each in flights.values() for name in shares(each)))
    rows = [
        (flight, *(f"{shares(each)[name]:.3f}" if name in shares(each) else "N/A" for name in names))
        for flight, each in flights.items()
    ]
    return "\n".join([f"{title}:", *aligned([("flight", *names), *rows])])


def _verdicts(model: str, flights: Mapping[str, FlightThresholds]) -> Iterator[str]:
    yield (
        f"On each flight at most {OVER:.0%} of the windows without a fault should be over the threshold, the AUC of "
        f"each fault {AUC} or more, at most {MISSED:.0%} of the windows with it not over the threshold, and "
        f"{CURED:.0%} or more of those after its cure."
    )
    own = [flight for flight, each in flights.items() if OF_CARD in each.made_of]
    if own:
        yield (
            f"On {listed(own)} runs have the thresholds of the model's card, which were not found on this flight."
        )
    beyond = {flight: each.shortfalls() for flight, each in flights.items() if each.shortfalls()}
    for flight, texts in beyond.items():
        yield f"Beyond {model} is {flight}: {listed(texts)}."
    if not beyond:
        yield f"All of it holds for {model}."

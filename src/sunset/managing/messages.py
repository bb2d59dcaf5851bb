"""The messages that a managing system publishes for the record, with checked content."""

from collections.abc import Mapping
from typing import Final

from sunset.system_interfaces.msg import Cost, Diagnosis
from sunset_ros.texts import shorten, shown

LONGEST_THOUGHT_S: Final = 3600.0
"""The longest time to think; no experiment measures more."""
MOST_TOKENS: Final = 10**9
"""The most tokens of a decision."""
HIGHEST_PRICE: Final = 10**6
"""The highest price of a decision."""
LONGEST_MODEL: Final = 100
"""The longest name of a model, in characters."""


def diagnosis_message(probabilities: Mapping[str, float]) -> Diagnosis:
    """Return a diagnosis, without a stamp.

    Raises:
        ValueError: a fault's name is not a text, or a probability is not a number from 0 to 1.
    """
    if not isinstance(probabilities, Mapping):
        raise ValueError(f"A diagnosis must map faults to probabilities, got {shown(probabilities)}.")  # noqa: TRY004  one kind of error for a bad value
    for fault, probability in probabilities.items():
        if not isinstance(fault, str):
            raise ValueError(f"The name of a fault in a diagnosis must be a text, got {shown(fault)}.")  # noqa: TRY004  likewise
        if not is_number(probability, 1):
            raise ValueError(
                f"The probability of {shorten(fault)} must be a number from 0 to 1, got {shown(probability)}."
            )
    return Diagnosis(
        faults=list(probabilities), probabilities=[float(each) for each in probabilities.values()]
    )


def cost_message(model: str, tokens_in: int, tokens_out: int, price: float) -> Cost:
    """Return what a decision has cost, without a stamp.

    Raises:
        ValueError: a value has the wrong type, or is out of range.
    """
    if not isinstance(model, str) or len(model) > LONGEST_MODEL:
        raise ValueError(
            f"The model of a cost must be a text of at most {LONGEST_MODEL} characters, got {shown(model)}."
        )
    for name, tokens in (("tokens_in", tokens_in), ("tokens_out", tokens_out)):
        if not is_number(tokens, MOST_TOKENS) or not isinstance(tokens, int):
            raise ValueError(
                f"{name} of a cost must be a whole number from 0 to {MOST_TOKENS}, got {shown(tokens)}."
            )
    if not is_number(price, HIGHEST_PRICE):
        raise ValueError(
            f"The price of a cost must be a number from 0 to {HIGHEST_PRICE}, got {shown(price)}."
        )
    return Cost(model=model, tokens_in=tokens_in, tokens_out=tokens_out, price=float(price))


def is_number(value: object, most: float) -> bool:
    """Return whether a value is a number from 0 to the greatest allowed number; True and False are not."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= most

"""The agreement report, as a table, CSV or JSON."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.agreement import TOLERANCE, TOLERANCE_S, Agreement, LeftOut, Pair, agrees
from sunset.evaluation.blocks import wrapped
from sunset.evaluation.intervals import NO_INTERVAL
from sunset.evaluation.paired import Difference
from sunset.texts.sentences import counted, csv_text
from sunset.texts.tables import aligned, table_width

AGREEMENT_FORMATS: Final = ("table", "csv", "json")

_METHOD: Final = (
    "Differences are live − sim, of pairs with the same scenario and seed; their mean with its 95 % confidence "
    "interval from the components of variance of crossed random effects: pairs with the same degradations, and of the "
    "same seed, are alike."
)
_RULE: Final = (
    f"A figure agrees if the live mean is within {100 * TOLERANCE:g} % of the simulation's or, of a time, within "
    f"{TOLERANCE_S:g} s."
)
_COLUMNS: Final = ("figure", "sim", "live", "live − sim", "95 % interval", "pairs", "agrees")


def format_agreement(agreements: Sequence[Agreement], form: str = "table") -> str:
    """Return the agreement report in one of `AGREEMENT_FORMATS`; as CSV the figures only.

    Raises:
        InvalidInputError: the format is unknown.
    """
    match form:
        case "table":
            several = len({agreement.flight.bag for agreement in agreements}) > 1
            parts = ["\n".join([*_text(agreement, bag=several), ""]) for agreement in agreements]
            return "\n".join([*parts, *map(wrapped, _notes(agreements))]) + "\n"
        case "csv":
            return _as_csv(agreements)
        case "json":
            return _as_json(agreements)
    known = ", ".join(AGREEMENT_FORMATS)
    raise InvalidInputError(f"The format of an agreement report must be one of {known}, got {form!r}.")


def _notes(agreements: Sequence[Agreement]) -> tuple[str, ...]:
    estimates = [compared.difference for agreement in agreements for compared in agreement.differences]
    lacking = any(estimate and estimate.lacks_interval for estimate in estimates)
    return (_METHOD, *((NO_INTERVAL,) if lacking else ()), _RULE)


def _text(agreement: Agreement, *, bag: bool) -> Iterator[str]:
    """Yield the lines about a managing system."""
    pairs = agreement.pairs
    model = f"{agreement.model}{agreement.flight.label(bag=bag)}"
    yield (
        f"{agreement.manager} on {agreement.suite or 'scenarios of no suite'}, model {model}: "
        f"{counted(len(pairs), 'pair')}, {len(agreement.left_out)} left out"
    )
    yield ""
    if pairs:
        rows = [_COLUMNS, *map(_cells, agreement.differences)]
        head, *lines = aligned(rows, left=(0, len(_COLUMNS) - 1))
        yield from (head, "─" * table_width(rows), *lines, "")
        yield from (
            f"Only one of the two runs has {compared.figure} in {counted(compared.one_sided, 'more pair')}."
            for compared in agreement.differences
            if compared.one_sided
        )
        same_failures = [pair.same_failures for pair in pairs]
        same_adaptations = [pair.same_adaptations for pair in pairs]
        yield f"The same failures appeared in {_share(pairs, same_failures)}."
        yield f"The same adaptations were executed in {_share(pairs, same_adaptations)}."
        yield from _differing(pairs)
    if agreement.left_out:
        yield "Left out:"
        yield from (_item(run, run.reason) for run in agreement.left_out)


def _differing(pairs: Sequence[Pair]) -> Iterator[str]:
    """Yield the lines about pairs that differ in their failures or adaptations."""
    differing = [pair for pair in pairs if not (pair.same_failures and pair.same_adaptations)]
    if differing:
        yield "Where they differ (sim → live):"
    for pair in differing:
        if not pair.same_failures:
            sim, live = (" ".join(failures) or "none" for failures in pair.failures)
            yield _item(pair, f"failures {sim} → {live}")
        if not pair.same_adaptations:
            yield _item(pair, _changes(*pair.adaptations))


def _item(run: Pair | LeftOut, text: str) -> str:
    return wrapped(f"  {run.scenario}, seed {run.seed}: {text}", "    ")


def _cells(compared: Difference) -> tuple[str, ...]:
    verdict = {True: "yes", False: "no", None: "N/A"}[agrees(compared)]
    estimate = compared.difference
    if estimate is None:
        return (compared.figure, "N/A", "N/A", "N/A", "", "0", verdict)
    interval = "[{:+.3f}, {:+.3f}]".format(*estimate.interval) if estimate.interval else ""
    means = (f"{compared.second:.3f}", f"{compared.first:.3f}", f"{estimate.mean:+.3f}")
    return (compared.figure, *means, interval, str(compared.pairs), verdict)


def _share(pairs: Sequence[Pair], verdicts: Sequence[bool]) -> str:
    """Return in how many pairs, and in all pairs of how many scenarios, a condition holds."""
    every = {pair.scenario for pair in pairs}
    broken = {pair.scenario for pair, holds in zip(pairs, verdicts, strict=True) if not holds}
    return (
        f"{sum(verdicts)} of {counted(len(pairs), 'pair')}, "
        f"throughout in {len(every) - len(broken)} of {counted(len(every), 'scenario')}"
    )


def _changes(sim: dict[str, int], live: dict[str, int]) -> str:
    """Return the adaptations that were executed more or less often live."""
    names = sorted(sim | live)
    counts = [(name, sim.get(name, 0), live.get(name, 0)) for name in names]
    return ", ".join(f"{name} {before} → {after}" for name, before, after in counts if before != after)


def _as_json(agreements: Sequence[Agreement]) -> str:
    content = {
        "rows": [
            {
                "manager": agreement.manager,
                "suite": agreement.suite,
                "model": agreement.model,
                **agreement.flight.to_json(),
                "pairs": len(agreement.pairs),
                "figures": {compared.figure: _json(compared) for compared in agreement.differences},
                "scenarios": [_json_pair(pair) for pair in agreement.pairs],
                "left_out": [asdict(left) for left in agreement.left_out],
            }
            for agreement in agreements
        ],
        "method": _METHOD,
        "rule": _RULE,
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _json(compared: Difference) -> dict[str, object]:
    return {
        "sim": compared.second,
        "live": compared.first,
        "difference": compared.difference and compared.difference.to_json(),
        "pairs": compared.pairs,
        "one_sided": compared.one_sided,
        "agrees": agrees(compared),
    }


def _json_pair(pair: Pair) -> dict[str, object]:
    failures, adaptations = pair.failures, pair.adaptations
    return {
        "scenario": pair.scenario,
        "seed": pair.seed,
        "same_failures": pair.same_failures,
        "same_adaptations": pair.same_adaptations,
        "failures": {"sim": list(failures[0]), "live": list(failures[1])},
        "adaptations": {"sim": adaptations[0], "live": adaptations[1]},
    }


def _as_csv(agreements: Sequence[Agreement]) -> str:
    head = ("manager", "suite", "model", "duration_s", "bag_looped", "flight", "bag_checksum")
    rows: list[tuple[object, ...]] = [
        (*head, "figure", "sim", "live", "difference", "ci_low", "ci_high", "pairs", "one_sided", "agrees")
    ]
    for agreement in agreements:
        group = (agreement.manager, agreement.suite, agreement.model, *agreement.flight.to_json().values())
        for compared in agreement.differences:
            estimate = compared.difference
            numbers = (estimate.mean, estimate.low, estimate.high) if estimate else (None,) * 3
            counts = (compared.pairs, compared.one_sided, agrees(compared))
            rows.append((*group, compared.figure, compared.second, compared.first, *numbers, *counts))
    return csv_text(rows)

"""A model card as text for reading."""

from collections.abc import Iterator, Mapping, Sequence


def card_text(card: Mapping[str, object]) -> str:
    """Return the Markdown of a card's JSON object.

    >>> print(card_text({"name": "lite", "version": "1", "description": "Small.", "width": 256}))
    # lite, version 1
    <BLANKLINE>
    Small.
    <BLANKLINE>
    - width: 256
    <BLANKLINE>
    """
    lines = [f"# {card['name']}, version {card['version']}", "", str(card["description"]), ""]
    head = ("name", "version", "description", "format")
    lines += _section({key: value for key, value in card.items() if key not in head}, 2)
    return "\n".join(lines).rstrip() + "\n"


def _section(content: Mapping[str, object], level: int) -> Iterator[str]:
    plain = {key: value for key, value in content.items() if not isinstance(value, Mapping)}
    for key, value in plain.items():
        yield f"- {_words(key)}: {_cell(value)}"
    if plain:
        yield ""
    for key, value in content.items():
        if isinstance(value, Mapping) and value:
            yield f"{'#' * level} {_words(key).capitalize()}"
            yield ""
            yield from _table(value) if _is_table(value) else _section(value, level + 1)


def _is_table(content: Mapping[str, object]) -> bool:
    return all(
        isinstance(row, Mapping) and not any(isinstance(cell, Mapping) for cell in row.values())
        for row in content.values()
    )


def _table(rows: Mapping[str, object]) -> Iterator[str]:
    maps = {key: row for key, row in rows.items() if isinstance(row, Mapping)}
    columns = list(dict.fromkeys(str(column) for row in maps.values() for column in row))
    yield "| | " + " | ".join(_words(column) for column in columns) + " |"
    yield "|---|" + "---|" * len(columns)
    for key, row in maps.items():
        yield f"| {_words(key)} | " + " | ".join(_cell(row.get(column, "")) for column in columns) + " |"
    yield ""


def _words(key: str) -> str:
    return key.replace("_", " ")


def _cell(value: object) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(_cell(item) for item in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)

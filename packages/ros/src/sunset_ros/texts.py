"""Texts that messages quote: made printable, shortened, suggested."""

import difflib
import reprlib
from collections.abc import Iterable
from typing import Final

_LONGEST_SENTENCE: Final = 2000
"""In characters."""


def printable(text: str) -> str:
    r"""Return `text` with escapes in place of control characters; lines and tabs stay.

    >>> printable("\x1b[2JFlight ü\u202e")
    '\\x1b[2JFlight ü\\u202e'
    """
    if text.isprintable():
        return text
    return "".join(
        character
        if character.isprintable() or character in "\n\t"
        else character.encode("unicode_escape").decode()
        for character in text
    )


def shorten(text: str, longest: int = 1000) -> str:
    """Return a text that a message quotes, cut to so many characters.

    >>> shorten("a" * 30, 10)
    'aaaaaaaaaa…'
    """
    return text if len(text) <= longest else f"{text[:longest]}…"


def sentence(text: str) -> str:
    """Return a sentence with quoted texts, made printable, and without its middle if it is far too long.

    >>> len(sentence("Unknown scenario " + "x" * 5000 + ": name another."))
    2000
    """
    text = printable(text)
    if len(text) <= _LONGEST_SENTENCE:
        return text
    end = _LONGEST_SENTENCE // 3
    return f"{text[: _LONGEST_SENTENCE - end - 1]}…{text[-end:]}"


def shown(value: object) -> str:
    """Return the representation of any value, as a message quotes it.

    >>> shown("1"), shown(10**5000)
    ("'1'", 'a whole number of thousands of digits')
    """
    try:
        return reprlib.repr(value)
    except ValueError:  # Python does not write so long a number
        return "a whole number of thousands of digits"


def suggestion(name: object, known: Iterable[str], prefix: str = "") -> str:
    """Return the part of a sentence that asks whether a known name was meant; empty if no name is similar.

    Both are compared without their `prefix`, which stands before the suggested name.

    >>> f"Unknown fault 'gpu_failur': {suggestion('gpu_failur', ['gpu_failure'])}choose another."
    "Unknown fault 'gpu_failur': did you mean 'gpu_failure', or choose another."
    """
    near = difflib.get_close_matches(str(name), list(known), n=1)
    return f"did you mean {prefix + near[0]!r}, or " if near else ""

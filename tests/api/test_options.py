"""Names that are given as one text."""

import pytest

from sunset.api.arguments import names_of


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("none, baseline,", ("none", "baseline")),
        ("a=exec:awk -F ',' -f m.awk,none", ("a=exec:awk -F ',' -f m.awk", "none")),
        ('exec:x "a\\",b",none', ('exec:x "a\\",b"', "none")),
        ("exec:awk -F\\, x,none", ("exec:awk -F\\, x", "none")),
        ("it's.py:Mine,none", ("it's.py:Mine", "none")),
        ("", ()),
    ],
)
def test_commas_separate_names_but_not_in_quotes(text: str, names: tuple[str, ...]) -> None:
    assert names_of(text, "managing systems") == names

"""The record of the last run that was given no folder of its own."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from sunset.experiments import keep_last_run, last_run


def test_of_records_that_are_kept_at_once_one_is_left_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    records = [tmp_path / f"record-{number}" for number in range(40)]
    for record in records:
        record.mkdir()
        for name in ("run.json", "messages.mcap"):
            (record / name).write_text(record.name, encoding="utf-8")

    with ThreadPoolExecutor(8) as pool:
        kept = set(pool.map(keep_last_run, records))

    assert kept == {last_run()}
    written = [path.read_text(encoding="utf-8") for path in last_run().iterdir()]
    assert len(written) == 2
    assert len(set(written)) == 1
    assert list((tmp_path / "cache").iterdir()) == [last_run()]
    assert not any(record.exists() for record in records)

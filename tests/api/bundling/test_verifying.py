"""What was changed in a bundle is found and named, even where the list of checksums was changed along."""

import json
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.api.bundling.conftest import DATE, IMPORTED, SETTINGS, Forge

from sunset.api.bundling import bundle, verify
from sunset.api.bundling.verifying import Verification
from sunset.api.catalogue import generate_split
from sunset.experiments import BenchSpec, bench
from sunset.recording import SETTINGS as RESULT_SETTINGS
from sunset.recording import read_plan
from sunset.recording._bag import Payload, digest_of, read_bag, write_bag
from sunset.scenarios import load_scenario, split_hash
from sunset.system import extended_system

pytestmark = pytest.mark.xdist_group("bundling")

WET = "campaign/runs/own/none/wet/seed-1"
OTHER_SEED = "campaign/runs/own/none/wet/seed-2"
MINE = "campaign/runs/own/mine/wet/seed-1"

Edit = Callable[[Path], object]


def changed(file: str, **values: object) -> Edit:
    """Return what changes keys of a JSON file; those of dictionaries in it by `outer__inner`; `...` removes one."""

    def edit(folder: Path) -> None:
        content = json.loads((folder / file).read_text())
        for name, value in values.items():
            inner: Any = content
            *outer, last = name.split("__")
            for key in outer:
                inner = inner[int(key) if key.isdecimal() else key]
            inner[last] = value
            if value is ...:
                del inner[last]
        (folder / file).write_text(json.dumps(content))

    return edit


def replaced(run: str, by: str) -> Edit:
    """Return what puts the record of one run in the place of another's."""

    def edit(folder: Path) -> None:
        shutil.rmtree(folder / run)
        shutil.copytree(folder / by, folder / run)

    return edit


def swapped(folder: Path) -> None:
    (folder / WET).rename(folder / "aside")
    (folder / OTHER_SEED).rename(folder / WET)
    (folder / "aside").rename(folder / OTHER_SEED)


def with_messages(edit: Callable[[list[Payload]], list[Payload]], *, digest: bool) -> Edit:
    """Return what changes the messages of a run, and its digest too if that is asked for."""

    def apply(folder: Path) -> None:
        payloads = edit(list(read_bag(folder / WET)))
        for name in ("messages.mcap", "metadata.yaml"):
            (folder / WET / name).unlink()
        write_bag(folder / WET, payloads)
        if digest:
            changed(f"{WET}/run.json", digest=digest_of(payloads))(folder)

    return apply


def without_last_clock(payloads: list[Payload]) -> list[Payload]:
    last = max(place for place, payload in enumerate(payloads) if payload.topic == "/clock")
    return payloads[:last] + payloads[last + 1 :]


def flipped(folder: Path) -> None:
    file = folder / WET / "messages.mcap"
    content = bytearray(file.read_bytes())
    chunk = 17 + int.from_bytes(
        content[9:17], "little"
    )  # behind magic and header record; messages are at its end
    content[chunk + int.from_bytes(content[chunk + 1 : chunk + 9], "little") - 53] ^= 0xFF
    file.write_bytes(content)


def appended(name: str, text: str = "# changed\n") -> Edit:
    def edit(folder: Path) -> None:
        with (folder / name).open("a") as file:
            file.write(text)

    return edit


def test_what_is_run_for_the_score_is_verified_too(flight: Path, tmp_path: Path) -> None:
    assert flight.exists()
    spec = BenchSpec(
        suite="single",
        scenarios=("gpu_failure",),
        managers=("baseline",),
        references=False,
        repetitions=1,
        settings=SETTINGS,
    )
    bench(spec, tmp_path / "results", jobs=1)
    bundle(tmp_path / "results", tmp_path / "results.zip", date=DATE)

    found = verify(tmp_path / "results.zip", run_again=0, seed=1)

    assert found.problems == ()
    assert sorted(read_plan(tmp_path / "results").manager_checksums) == ["baseline", "none", "oracle"]


OTHERS: dict[str, object] = {name: "diagnose" if name == "task" else 0.5 for name in RESULT_SETTINGS}
"""Other values of the settings on which results depend."""

DAMAGES: dict[str, tuple[Edit, str, str]] = {
    "figure": (
        changed(f"{WET}/run.json", metrics__t_down_s=0.5),
        WET,
        "its t_down_s is stored as 0.5, and the messages give 2",
    ),
    "figure that is not applicable": (
        changed(f"{WET}/run.json", metrics__t_react_s=1.0),
        WET,
        "its t_react_s is stored as 1, and the messages give N/A",
    ),
    "figure that is missing": (changed(f"{WET}/run.json", metrics={}), WET, "must be"),
    "damaged messages": (flipped, WET, "is damaged: "),
    "message": (with_messages(without_last_clock, digest=False), WET, "gives the digest"),
    "record of another seed": (
        replaced(WET, OTHER_SEED),
        WET,
        "it is the record of seed 2 of wet with none",
    ),
    "record of another managing system": (
        replaced(WET, MINE),
        WET,
        "it is the record of seed 1 of wet with mine",
    ),
    "swapped runs": (swapped, OTHER_SEED, "it is the record of seed 1 of wet with none"),
    "missing run": (
        lambda folder: shutil.rmtree(folder / MINE),
        "campaign/bench.json",
        "mine has no run of wet, seed 1, on the flight default",
    ),
    "run too many": (
        lambda folder: shutil.copytree(folder / WET, folder / WET.replace("seed-1", "seed-3")),
        "campaign/bench.json",
        "it has 4 runs, and 5 can be read",
    ),
    "run of another campaign's managing system": (
        changed("campaign/bench.json", managers=["none", "yours=mine.py:Mine"]),
        MINE,
        "no run of mine with seed 1 is part of the plan",
    ),
    "record of another campaign": (
        changed(f"{WET}/run.json", versions__numpy="1.0.0"),
        WET,
        "its versions.numpy is '1.0.0', and '",
    ),
    **{
        f"another {name}": (
            changed(f"{WET}/run.json", **{name: value}),
            WET,
            f"its {name} is {value!r}, and ",
        )
        for name, value in OTHERS.items()
    },
    "plan of unknown sources": (
        changed("campaign/bench.json", manager_checksums={}),
        MINE,
        ", and nothing in the plan",
    ),
    "plan of another flight": (
        changed("campaign/bench.json", bag_checksum="0" * 64),
        WET,
        "its bag_checksum is ",
    ),
    "model": (
        changed("model/card.json", entropy_threshold=0.9),
        "campaign/bench.json",
        "its model differs from the card that is there",
    ),
    "source": (appended("managers/mine/mine.py"), "managers", "the source of mine (managers/mine/"),
    "source beside it": (
        appended("managers/mine/helper.py"),
        "managers",
        "the source of mine (managers/mine/",
    ),
    "source elsewhere": (
        changed("bundle.json", managers__mine__files=["/etc/passwd"]),
        "managers",
        "the source of mine (/etc/passwd) differs from the plan",
    ),
    "table": (appended("report.txt"), "report.txt", "it differs from the table of the runs' figures"),
}

TOGETHER = (
    "figure",
    "figure that is not applicable",
    "plan of another flight",
    "model",
    "source",
    "source beside it",
    *(f"another {name}" for name in OTHERS),
)
"""Damages that do not hide each other."""


@pytest.mark.parametrize(
    "names",
    [
        TOGETHER,
        *(
            pytest.param((name,), marks=[] if "record" in name or "run" in name else [pytest.mark.thorough])
            for name in DAMAGES
            if name not in TOGETHER
        ),
    ],
    ids=lambda names: names[0],
)
def test_what_does_not_fit_together_is_found_although_the_checksums_fit(
    names: tuple[str, ...], packed: Path, forge: Forge
) -> None:
    def edit(folder: Path) -> None:
        for name in names:
            DAMAGES[name][0](folder)

    found = verify(forge(packed, edit), run_again=0, seed=1)

    for name in names:
        _, where, what = DAMAGES[name]
        hits = [text for text in found.problems if text.startswith(f"{where}: ") and what in text]
        assert hits, (name, found.problems)
    problems = f"{len(found.problems)} problem{'s' * (len(found.problems) > 1)}"
    assert str(found).endswith(f"\nNot verified: {problems}.")


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        (appended("README.md"), "README.md: it was changed, since its checksum differs from SHA256SUMS."),
        (
            lambda folder: (folder / "README.md").unlink(),
            "README.md: it is missing, although SHA256SUMS lists it.",
        ),
        (lambda folder: (folder / "more").write_text(""), "more: SHA256SUMS does not list it."),
        (
            lambda folder: (folder / "SHA256SUMS").unlink(),
            "SHA256SUMS: it is missing, or is not a text.",
        ),
    ],
)
def test_the_checksums_are_compared(edit: Edit, expected: str, packed: Path, forge: Forge) -> None:
    assert verify(forge(packed, edit, sums=False), run_again=0, seed=1).problems == (expected,)


def test_what_fits_together_and_never_happened_is_found_by_running_it_again(
    packed: Path, forge: Forge
) -> None:
    forged = forge(packed, with_messages(without_last_clock, digest=True))

    assert verify(forged, run_again=0, seed=1).passed
    (problem,) = verify(forged, run_again=99, seed=1).problems
    assert problem.startswith(f"{WET}: The run in {WET} was run again, and left other messages")


def test_of_a_forged_figure_only_that_figure_is_said_to_differ_when_it_is_run_again(
    packed: Path, forge: Forge
) -> None:
    forged = forge(packed, changed(f"{WET}/run.json", metrics__t_down_s=0.5))

    again = [
        problem for problem in verify(forged, run_again=99, seed=1).problems if "running it again" in problem
    ]

    (sentence,) = again
    assert sentence.startswith(f"{WET}: Its t_down_s is stored as 0.5, and running it again gave 2")
    assert "{" not in sentence


def beside_walls(found: Verification) -> list[str]:
    """Return what could not be checked, but for what managing systems do on a system that lacks walls."""
    return [text for text in found.unchecked if not text.endswith(" around it.")]


def test_an_untouched_bundle_verifies_and_runs_none_of_its_code(
    packed: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capfd.readouterr()

    found = verify(packed, run_again=99, seed=1)

    assert found.passed
    assert str(found).endswith("\nVerified.")
    assert (found.runs_recomputed, len(found.runs_again)) == (4, 2)
    (unchecked,) = beside_walls(found)
    assert unchecked == (
        "2 runs could not be run again: that runs the code of mine, which the bundle has; read it, and let it run with "
        "--trust."
    )
    assert IMPORTED not in capfd.readouterr().err


def test_what_is_trusted_is_run_again_from_the_source_in_the_bundle(
    results: Path, packed: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capfd.readouterr()
    (results.parent / "helper.py").rename(results.parent / "gone.py")
    try:
        found = verify(packed, run_again=99, seed=1, trust=True)
    finally:
        (results.parent / "gone.py").rename(results.parent / "helper.py")

    assert (found.problems, beside_walls(found), len(found.runs_again)) == ((), [], 4)
    assert IMPORTED in capfd.readouterr().err


@pytest.mark.thorough
def test_the_seed_chooses_which_runs_are_run_again(packed: Path) -> None:
    chosen = {verify(packed, run_again=1, seed=seed).runs_again for seed in range(4)}

    assert chosen == {(WET.removeprefix("campaign/"),), (OTHER_SEED.removeprefix("campaign/"),)}
    assert verify(packed, run_again=1, seed=3).runs_again in chosen


EXTENSION = f"""
import sys

from sunset.system import Extension

print("{IMPORTED}", file=sys.stderr)
EXTENSION = Extension(suites={{"dark": (("image_degradation=1.2",), ("image_degradation=1.4",))}})
"""


@pytest.mark.thorough
def test_an_extension_is_packed_and_runs_only_where_it_is_trusted(
    tmp_path: Path, forge: Forge, capfd: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "darker.py"
    source.write_text(EXTENSION)
    packed = tmp_path / "dark.zip"
    with extended_system([source]):
        spec = BenchSpec(
            suite="dark",
            scenarios=("image_degradation=1.2",),
            managers=("none",),
            references=False,
            score=False,
            repetitions=1,
            settings=SETTINGS,
        )
        bench(spec, tmp_path / "results", jobs=1)
        bundle(tmp_path / "results", packed, date=DATE)
    capfd.readouterr()

    careful = verify(packed, run_again=99, seed=1)

    assert IMPORTED not in capfd.readouterr().err

    trusting = verify(packed, run_again=99, seed=1, trust=True)

    assert (careful.passed, careful.runs_recomputed, careful.runs_again) == (True, 0, ())
    assert str(careful).endswith("\nNothing is wrong, but no figure was checked.")
    (unchecked,) = careful.unchecked  # the table is compared: records have what it needs of the extension
    assert unchecked.endswith("needs the campaign's extensions (darker.py), whose code --trust lets run.")
    assert (trusting.passed, trusting.runs_recomputed, len(trusting.runs_again)) == (True, 1, 1)
    assert IMPORTED in capfd.readouterr().err
    forged = verify(
        forge(packed, appended("extensions/darker.py/darker.py")), run_again=99, seed=1, trust=True
    )
    (problem,) = forged.problems
    assert problem == (
        "extensions: the source of darker.py (extensions/darker.py/darker.py) differs from the plan's checksum."
    )
    assert IMPORTED not in capfd.readouterr().err


OLD = "0.0.9+0f0f0f0f"


def of_another_version(folder: Path) -> None:
    changed("campaign/bench.json", versions__sunset=OLD)(folder)
    for file in (folder / "campaign").glob("runs/*/*/*/*/run.json"):
        changed(str(file.relative_to(folder)), versions__sunset=OLD)(folder)


def test_a_bundle_of_another_version_is_not_damaged(packed: Path, forge: Forge) -> None:
    def edit(folder: Path) -> None:
        of_another_version(folder)
        changed(f"{WET}/run.json", metrics__t_down_s=0.5)(folder)
        appended("report.txt")(folder)

    found = verify(forge(packed, edit), run_again=99, seed=1)

    assert (found.passed, found.problems, found.runs_recomputed) == (False, (), 4)
    assert found.differences[0] == f"{WET}: its t_down_s is stored as 0.5, and the messages give 2."
    assert f"SUNSET {OLD} made the bundle, and this is " in str(found.unchecked)
    assert str(found).endswith(
        f"\nNot damaged, but made by another version of SUNSET: {len(found.differences)} results of this one differ."
    )


def test_a_bundle_has_the_scenarios_of_all_its_runs(flight: Path, tmp_path: Path) -> None:
    assert flight.exists()
    spec = BenchSpec(
        suite="timed",
        scenarios=("gpu_failure+image_shift+depth_degradation",),
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
    )
    bench(spec, tmp_path / "results", jobs=1)
    bundle(tmp_path / "results", tmp_path / "results.zip", date=DATE)

    with zipfile.ZipFile(tmp_path / "results.zip") as archive:
        archive.extractall(tmp_path / "opened")
    (file,) = (tmp_path / "opened").glob("scenarios/timed/*.yaml")
    assert load_scenario(str(file)).faults == load_scenario(f"timed/{spec.scenarios[0]}").faults


@pytest.mark.thorough
@pytest.mark.usefixtures("flight")
def test_a_campaign_on_a_split_keeps_what_pins_it(tmp_path: Path) -> None:
    described = generate_split("train", 1, tmp_path / "split", seed=4)
    bench(
        BenchSpec(
            suite=str(tmp_path / "split"), managers=("none",), references=False, score=False, repetitions=1
        ),
        tmp_path / "results",
        jobs=1,
    )
    bundle(tmp_path / "results", out := tmp_path / "results.zip", date=DATE)

    assert read_plan(tmp_path / "results").split == described.sha256
    assert verify(out, run_again=0, seed=1).passed
    with zipfile.ZipFile(out) as archive:
        archive.extractall(tmp_path / "opened")
    assert split_hash(str(tmp_path / "opened/scenarios/split")) == described.sha256

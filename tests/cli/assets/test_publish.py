"""`mana assets publish`: what may be passed on goes into a release whose files can be checked; nothing else does."""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cli.main import app
from schemas.diagnostics import InvalidInput
from tests.support.library.library_samples import packaged, recorded, stated
from tests.support.package_samples import box_mesh, content, model

ADA = {"license": stated("CC-BY-4.0"), "author": stated("Ada")}


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """Two packages of Ada's under CC-BY-4.0."""
    out = tmp_path / "library"
    for name in ("bowl", "mug"):
        packaged(out, content(model([box_mesh()]), asset_id=name), ADA, outcome="accepted")
    return out


def publish(*arguments: object) -> tuple[int, dict[str, Any]]:
    result = CliRunner().invoke(app, ["assets", "publish", *map(str, arguments), "--json"], catch_exceptions=False)
    return result.exit_code, json.loads(result.output)


def tree(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_release_holds_packages_licences_attributions_and_the_hash_of_every_file(library: Path) -> None:
    release = library.parent / "release"
    code, answer = publish(library, "--out", release)
    assert (code, answer["assets"], answer["refused"], answer["warnings"]) == (0, ["bowl", "mug"], [], [])
    for name in ("bowl", "mug"):
        assert tree(release / "packages" / name) == tree(library / name)
    manifest = json.loads((release / "manifest.json").read_text())
    hashes = {name: hashlib.sha256(data).hexdigest() for name, data in tree(release).items() if name != "manifest.json"}
    assert manifest["files"] == hashes
    assert list(manifest["files"]) == sorted(hashes)
    assert [(a["asset_id"], a["licences"], a["author"]) for a in manifest["assets"]] == [
        ("bowl", ["CC-BY-4.0"], "Ada"),
        ("mug", ["CC-BY-4.0"], "Ada"),
    ]
    attribution = (release / "ATTRIBUTION.md").read_text()
    assert "**mug**: Ada;" in attribution
    assert "https://creativecommons.org/licenses/by/4.0/" in attribution
    assert "- bowl: Ada\n- mug: Ada" in (release / "LICENCES" / "CC-BY-4.0.md").read_text()
    checked = subprocess.run(  # an outsider: coreutils
        ["sha256sum", "-c", "--quiet"],
        input="".join(f"{sha}  {name}\n" for name, sha in manifest["files"].items()),
        cwd=release,
        text=True,
        check=False,
    )
    assert checked.returncode == 0


def test_two_releases_of_equal_packages_are_equal_and_one_replaces_the_other(library: Path) -> None:
    one, two = library.parent / "one", library.parent / "two"
    for place in (one, two, one):
        assert publish(library, "--out", place)[0] == 0
    assert tree(one) == tree(two)
    recorded(library / "mug", ADA | {"license": stated("MIT")}, outcome="accepted")
    assert publish(library, "mug", "--out", one)[0] == 0
    assert sorted(p.name for p in (one / "packages").iterdir()) == ["mug"]
    text = (one / "LICENCES" / "MIT.md").read_text()
    assert "Permission is hereby granted, free of charge" in text
    assert sorted(p.name for p in library.parent.iterdir()) == ["library", "one", "two"]


REFUSALS: list[tuple[str, dict[str, Any], str]] = [
    ("no licence", {"source": {"license": stated("unknown")}}, "asset/licence-missing"),
    ("forbidden", {"source": {"license": stated("research use only")}}, "asset/licence-forbids-release"),
    ("not known", {"source": {"license": stated("my own terms")}}, "asset/licence-unrecognised"),
    ("non-commercial", {"source": ADA | {"license": stated("CC-BY-NC-4.0")}}, "asset/licence-restricted"),
    ("no derivatives", {"source": ADA | {"license": stated("CC-BY-ND-4.0")}}, "asset/licence-restricted"),
    ("in review", {"source": ADA, "outcome": "review"}, "asset/release-unaccepted"),
]


@pytest.mark.parametrize(
    ("change", "code"), [(c, code) for _, c, code in REFUSALS], ids=[name for name, _, _ in REFUSALS]
)
def test_what_may_not_be_passed_on_is_refused_with_its_code(change: dict[str, Any], code: str, library: Path) -> None:
    fields: dict[str, Any] = {"outcome": "accepted", **change}
    recorded(library / "mug", **fields)
    release = library.parent / "release"
    status, answer = publish(library, "--out", release)
    assert (status, [(r["code"], r["where"]["file"]) for r in answer["refused"]]) == (1, [(code, "mug")])
    assert sorted(p.name for p in library.parent.iterdir()) == ["library"]
    status, answer = publish(library, "--out", release, "--skip-refused")
    assert (status, answer["assets"]) == (0, ["bowl"])
    assert [p.name for p in (release / "packages").iterdir()] == ["bowl"]


@pytest.mark.parametrize(
    ("change", "allow"),
    [
        ({"source": ADA | {"license": stated("CC-BY-NC-ND-4.0")}}, ["nc", "nd"]),
        ({"source": ADA | {"license": stated("my own terms")}}, ["my own terms"]),
        ({"source": ADA, "outcome": "review"}, ["review"]),
    ],
)
def test_what_is_allowed_by_name_is_released(change: dict[str, Any], allow: list[str], library: Path) -> None:
    fields: dict[str, Any] = {"outcome": "accepted", **change}
    recorded(library / "mug", **fields)
    flags = [flag for each in allow for flag in ("--allow", each)]
    for number in range(len(flags) // 2):
        assert publish(library, "--out", library.parent / "r", *flags[: 2 * number])[0] == 1
    assert publish(library, "--out", library.parent / "r", *flags)[0] == 0


def test_an_author_that_nobody_recorded_is_a_warning_where_the_licence_asks_for_it(library: Path) -> None:
    recorded(library / "mug", {"license": stated("CC-BY-4.0"), "author": stated("unknown")}, outcome="accepted")
    recorded(library / "bowl", {"license": stated("CC0-1.0"), "author": stated("unknown")}, outcome="accepted")
    code, answer = publish(library, "--out", library.parent / "r")
    assert (code, [(w["code"], w["where"]["file"]) for w in answer["warnings"]]) == (
        0,
        [("asset/attribution-incomplete", "mug")],
    )


def test_a_damaged_package_and_a_foreign_folder_stop_a_release(library: Path) -> None:
    mine = library.parent / "mine"
    mine.mkdir()
    (mine / "letter.txt").write_text("mine")
    result = CliRunner().invoke(app, ["assets", "publish", str(library), "--out", str(mine)])
    assert isinstance(result.exception, InvalidInput)
    assert result.exception.diagnostic.code == "asset/output-occupied"  # `run` prints it with exit code 1
    assert tree(mine) == {"letter.txt": b"mine"}
    next((library / "mug").glob("usd/payloads/*.usda")).write_text("#usda 1.0\n")
    code, answer = publish(library, "--out", library.parent / "r")
    assert (code, [r["code"] for r in answer["refused"]]) == (1, ["asset/library-package-damaged"])


@pytest.mark.parametrize(
    ("damage", "headline"),
    [
        (lambda r: (r / "packages/mug/record.json").write_text("{}"), "'packages/mug/record.json' is changed"),
        (lambda r: (r / "ATTRIBUTION.md").unlink(), "'ATTRIBUTION.md' is absent"),
        (lambda r: (r / "packages/mug/virus.exe").write_text(""), "'packages/mug/virus.exe' is not in the manifest"),
    ],
)
def test_check_names_every_file_that_differs(damage: Callable[[Path], object], headline: str, library: Path) -> None:
    release = library.parent / "release"
    publish(library, "--out", release)
    assert publish("--check", release)[1]["findings"] == []
    damage(release)
    code, answer = publish("--check", release)
    assert code == 1
    assert [(f["code"], f["headline"]) for f in answer["findings"]] == [("asset/release-altered", headline)]


@pytest.mark.parametrize("text", [None, "{", '{"manifest_version": 99, "files": {}}'])
def test_a_folder_without_a_manifest_cannot_be_checked(text: str | None, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "manifest.json").write_text(text)
    result = CliRunner().invoke(app, ["assets", "publish", "--check", str(tmp_path)])
    assert isinstance(result.exception, InvalidInput)
    assert result.exception.diagnostic.code == "asset/release-unreadable"

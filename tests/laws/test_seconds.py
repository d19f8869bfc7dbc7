"""The table of seconds per package is complete, true to the tree and within the limit of `make test`."""

from __future__ import annotations

from tests.support.seconds import LISTED_S, TESTS, read_seconds, table_of

MOST_WALL_S = 15 * 60  # `make test` on two cores after installation
CORES = 2
NO_TESTS = {"data/", "support/"}


def test_every_package_of_tests_has_a_row_and_every_row_a_package() -> None:
    recorded = {path for path in read_seconds() if path.endswith("/")}
    folders = {f"{folder.name}/" for folder in TESTS.iterdir() if any(folder.rglob("test_*.py"))}
    assert recorded == folders - NO_TESTS


def test_listed_files_exist_and_are_long() -> None:
    files = {path: seconds for path, seconds in read_seconds().items() if not path.endswith("/")}
    assert [path for path in files if not (TESTS / path).is_file()] == []
    assert min(files.values()) >= LISTED_S


def test_all_packages_fit_into_a_quarter_of_an_hour_on_two_cores() -> None:
    assert sum(s for path, s in read_seconds().items() if path.endswith("/")) < MOST_WALL_S * CORES


def test_the_table_sums_folders_and_lists_long_files() -> None:
    rows = dict(table_of({"geom/test_a.py": 1.0, "geom/mesh/test_b.py": 3.0, "cli/test_c.py": 0.5}))
    assert rows == {"cli/": 0.5, "geom/": 4.0, "geom/mesh/test_b.py": 3.0}

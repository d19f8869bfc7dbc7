"""Seconds that tests take: the table `tests/seconds.csv`, the order of files, `--quick`, and a summary per package.

The table has one row per folder below `tests` (the sum of its files) and one per file of two seconds or more, as
measured by `pytest --record-seconds` with two worker processes on two cores. Files that take longest start first, since
a long one that starts last would leave the other worker idle. `--quick` leaves out the files of the table, so that what
is left takes under two minutes.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
TABLE = TESTS / "seconds.csv"
LISTED_S = 2.0  # a file below this has no row of its own and belongs to the quick ones


def read_seconds(table: Path = TABLE) -> dict[str, float]:
    """Seconds by path relative to `tests`: folders end in a slash."""
    if not table.is_file():
        return {}
    with table.open(newline="") as lines:
        return {row["path"]: float(row["seconds"]) for row in csv.DictReader(lines)}


def table_of(durations_s: Mapping[str, float]) -> list[tuple[str, float]]:
    """Rows of the table for measured seconds by file (relative to `tests`): folders by name, then long files."""
    folders: defaultdict[str, float] = defaultdict(float)
    for file, seconds in durations_s.items():
        folders[file.split("/")[0] + "/"] += seconds
    longest_first = sorted(durations_s.items(), key=lambda row: -row[1])
    long = [(file, seconds) for file, seconds in longest_first if seconds >= LISTED_S]
    return [(path, round(seconds, 1)) for path, seconds in (*sorted(folders.items()), *long)]


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--quick` and `--record-seconds`."""
    group = parser.getgroup("seconds")
    group.addoption("--quick", action="store_true", help=f"leave out files that take {LISTED_S:g} s or more")
    group.addoption("--record-seconds", action="store_true", help=f"write {TABLE.name} from this run")


def pytest_configure(config: pytest.Config) -> None:
    """Count in the process that sees all reports: the only one, or the controller of the workers."""
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(SecondsPlugin(config), "seconds-per-package")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Longest files first, the others as found; with `--quick` none of the long ones."""
    recorded = {TESTS / path: seconds for path, seconds in read_seconds().items() if not path.endswith("/")}
    items.sort(key=lambda item: -recorded.get(item.path, 0.0))
    if config.getoption("--quick"):
        long = [item for item in items if item.path in recorded]
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item.path not in recorded]


class SecondsPlugin:
    """Adds up the seconds of set-up, call and tear-down by file; prints the sums per package at the end."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._by_file: defaultdict[str, float] = defaultdict(float)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add one phase of one test."""
        path = Path(self._config.rootpath, report.nodeid.split("::")[0])
        if path.is_relative_to(TESTS):
            self._by_file[path.relative_to(TESTS).as_posix()] += report.duration

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """The table per package, and the file of it where asked for."""
        rows, before = table_of(self._by_file), read_seconds()
        if self._config.getoption("--record-seconds"):
            with TABLE.open("w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows([("path", "seconds"), *rows])
        if len(self._by_file) > 1:
            terminalreporter.write_sep("-", "seconds per package (recorded)")
            for path, seconds in rows:
                if path.endswith("/"):
                    terminalreporter.write_line(f"{seconds:8.1f} {before.get(path, 0.0):8.1f}  {path}")

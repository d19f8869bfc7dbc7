"""`python -m tools.golden record DIR` and `compare DIR`; see CONTRIBUTING.md."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from tools.golden.cases import GROUPS
from tools.golden.differences import Comparison, compare_cases
from tools.golden.run import REPO, Manifest, record

SHOWN = 5


def main(words: list[str] | None = None) -> int:
    """Exit code: 0 equal or recorded, 1 something differs, 2 called wrongly."""
    options = _parser().parse_args(words)
    shared = options.shared.resolve() if options.shared.is_dir() else None
    if shared is None:
        print("the shared data are absent; cases that need them are left out", file=sys.stderr)
    only = options.only or []
    try:
        if options.command == "record":
            manifest = record(options.folder, only, shared, _progress)
            print(f"{len(manifest.cases)} cases recorded in {options.folder}, {len(manifest.left_out)} left out")
            return 0
        if options.against:
            found = compare(options.folder, options.against, only)
        else:
            Manifest.read(options.folder)  # before minutes are spent
            with tempfile.TemporaryDirectory(prefix="golden_new_") as temporary:
                record(Path(temporary), only, shared, _progress)
                found = compare(options.folder, Path(temporary), only)
    except (FileExistsError, FileNotFoundError) as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps(asdict(found), indent=1) if options.json else text(found, options.show))
    return 0 if found.equal else 1


def compare(old: Path, new: Path, only: list[str]) -> Comparison:
    """Compare two recordings; cases that only one has are named as not compared."""
    before, after = Manifest.read(old), Manifest.read(new)
    wanted = {name for name in before.cases | after.cases if not only or name.split("/")[0] in only}
    apart = {name: before.left_out.get(name, "not in the recording") for name in wanted - before.cases.keys()}
    apart |= {name: after.left_out.get(name, "not in the new run") for name in wanted - after.cases.keys()}
    both, roots = sorted(wanted - apart.keys()), (before.roots, after.roots)
    return compare_cases(old / "outputs", new / "outputs", both, roots, dict(sorted(apart.items())))


def text(found: Comparison, show: int) -> str:
    """What differs, file by file, and counts; a file with the differences of an earlier one only names that one."""
    written: list[str] = []
    earlier: dict[tuple[str, ...], str] = {}
    for name, differences in found.differing.items():
        rows = tuple(map(str, differences))
        if rows in earlier and len(rows[0]) > len("the file [extra]"):
            written.append(f"{name}: as {earlier[rows]}")
            continue
        earlier[rows] = name
        written.append(f"{name}: {len(rows)} differences")
        written += [f"  {row}" for row in rows[:show]]
    written += [f"not compared: {name} ({why})" for name, why in found.not_compared.items()]
    kinds = Counter(kind for one in found.differing.values() for kind in {difference.kind for difference in one})
    counts = ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items()))
    written.append(
        f"{found.files} files compared: {len(found.differing)} differ{f' ({counts})' if counts else ''}, "
        f"{len(found.same_content)} have other bytes and equal content; {len(found.not_compared)} cases not compared"
    )
    return "\n".join(written)


def _progress(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tools.golden", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, words in (("record", "run the set and store what it writes"), ("compare", "run it again and compare")):
        command = commands.add_parser(name, help=words)
        command.add_argument("folder", type=Path, help="the recording")
        command.add_argument("--only", choices=GROUPS, action="append", help="a group; several times for several")
        command.add_argument("--shared", type=Path, default=REPO.parent / "shared" / "data", help="the shared data")
        if name == "compare":
            command.add_argument("--against", type=Path, help="another recording, instead of a new run")
            command.add_argument("--show", type=int, default=SHOWN, help="differences to print for each file")
            command.add_argument("--json", action="store_true", help="print JSON")
    return parser


if __name__ == "__main__":
    sys.exit(main())

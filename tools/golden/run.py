"""Runs cases in a temporary folder, two at a time, and stores what they wrote with a manifest.

A recording is a folder: `outputs/GROUP/CASE/...` holds the files as they were written, `logs/` what went to stderr,
`manifest.json` the cases with their seconds and the absolute paths that outputs may name.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from tools.golden.cases import Case, Place, Step, all_cases

REPO = Path(__file__).resolve().parents[2]
PROCESSES = 2
STEP_LIMIT_S = 400.0
_NOT_KEPT = (".cache", ".work")  # intermediate results, named by hashes over versions
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Manifest:
    """What a recording holds: seconds of each case, reasons of those left out, paths that stand for placeholders."""

    cases: dict[str, float]
    left_out: dict[str, str]
    roots: dict[str, str]

    @classmethod
    def read(cls, folder: Path) -> Manifest:
        """That of a recording. Raises FileNotFoundError where there is none."""
        return cls(**json.loads((folder / "manifest.json").read_text()))


def record(folder: Path, only: Sequence[str], shared: Path | None, say: Callable[[str], None]) -> Manifest:
    """Run the cases of the groups `only` (empty: all) and store them in `folder`, which is replaced if a recording.

    Raises FileExistsError where the folder holds something else.
    """
    if folder.exists() and any(folder.iterdir()):
        if not (folder / "manifest.json").is_file():
            raise FileExistsError(f"{folder} holds something else than a recording")
        shutil.rmtree(folder)
    _check_tree()
    wanted = [case for case in all_cases() if not only or case.group in only]
    left_out = {case.name: "needs the shared data" for case in wanted if case.shared and shared is None}
    wanted = [case for case in wanted if case.name not in left_out]
    with tempfile.TemporaryDirectory(prefix="golden_") as temporary:
        run = Path(temporary).resolve()
        seconds = _Run(run, shared, say).all(wanted)
        folder.mkdir(parents=True, exist_ok=True)
        for part in ("outputs", "logs"):
            shutil.copytree(run / part, folder / part, ignore=shutil.ignore_patterns(*_NOT_KEPT))
        for name in seconds.keys() - {case.name for case in wanted}:  # ran because others need it
            shutil.rmtree(folder / "outputs" / name)
        kept = {case.name: round(seconds[case.name], 1) for case in wanted}
        manifest = Manifest(kept, left_out, _roots(run, shared))
    (folder / "manifest.json").write_text(json.dumps(asdict(manifest), indent=1) + "\n")
    return manifest


def _roots(run: Path, shared: Path | None) -> dict[str, str]:
    found = {"run": run, "installed": _bullet().parent, "repo": REPO, "python": Path(sys.prefix)}
    return {name: str(path) for name, path in (found | ({"shared": shared} if shared else {})).items()}


def _bullet() -> Path:
    spec = importlib.util.find_spec("pybullet_data")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("pybullet_data is not installed")
    return Path(spec.origin).parent


def environment() -> dict[str, str]:
    """That of every command: the packages of this tree, one thread for each library, no colours, no settings."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("MANA_")}
    kept.pop("SOURCE_DATE_EPOCH", None)
    fixed = {"PYTHONPATH": str(REPO), "NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "300", "PYTHONDONTWRITEBYTECODE": "1"}
    return kept | fixed | dict.fromkeys(_THREADS, "1")


def _check_tree() -> None:
    """Raises RuntimeError when the commands would run another tree than the one this file is in."""
    ask = [sys.executable, "-P", "-c", "import cli; print(cli.__file__)"]
    found = subprocess.run(ask, cwd=REPO, env=environment(), capture_output=True, text=True, check=True).stdout.strip()
    if not Path(found).resolve().is_relative_to(REPO):
        raise RuntimeError(f"commands run {found}, which is not in {REPO}")


class _Run:
    """One pass over cases; every case runs once, also those that others come after."""

    def __init__(self, folder: Path, shared: Path | None, say: Callable[[str], None]):
        self._folder, self._shared, self._say = folder, shared, say
        self._started = time.monotonic()
        self._known = {case.name: case for case in all_cases()}
        self._pending: dict[str, Future[float]] = {}
        (folder / "logs").mkdir()

    def all(self, cases: Sequence[Case]) -> dict[str, float]:
        """Seconds of each case that ran, by name."""
        first = [self._known[case.after] for case in cases if case.after]
        with ThreadPoolExecutor(PROCESSES) as pool:  # in this order, so no case waits for one that comes later
            for name, case in {case.name: case for case in [*first, *cases]}.items():
                self._pending[name] = pool.submit(self._case, case)
        return {name: future.result() for name, future in self._pending.items()}

    def _case(self, case: Case) -> float:
        if case.after:
            self._pending[case.after].result()
        since = time.monotonic()
        out, made = self._folder / "outputs" / case.name, self._folder / "made" / case.name
        out.mkdir(parents=True)
        made.mkdir(parents=True)
        library = self._folder / "outputs" / "assets" / "packages" / "library"
        steps = case.steps(Place(REPO, out, made, library, _bullet(), self._shared))
        codes = {one.name: self._step(case, one, out) for one in steps}
        (out / "exit_codes.json").write_text(json.dumps(codes, indent=1) + "\n")
        took = time.monotonic() - since
        words = " ".join(f"{name}={code}" for name, code in codes.items() if code)
        self._say(f"{time.monotonic() - self._started:6.1f} s  {case.name} ({took:.1f} s) {words}")
        return took

    def _step(self, case: Case, one: Step, out: Path) -> int | str:
        """Exit code; "timeout" past the limit. Output goes to NAME.json where it is JSON, else to NAME.txt."""
        command = [sys.executable, "-m", one.module, *one.args]
        log = self._folder / "logs" / f"{case.name.replace('/', '.')}.{one.name}.txt"
        with log.open("wb") as errors:
            try:
                done = subprocess.run(
                    command, cwd=REPO, env=environment(), stdout=subprocess.PIPE, stderr=errors, timeout=STEP_LIMIT_S
                )
            except subprocess.TimeoutExpired:
                return "timeout"
        suffix = "json" if done.stdout.lstrip()[:1] in (b"{", b"[") else "txt"
        (out / f"{one.name}.{suffix}").write_bytes(done.stdout)
        return done.returncode

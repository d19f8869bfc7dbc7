"""Ask outside judges about a released package: NVIDIA's SimReady Foundation and OpenUSD's own validators."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import contextlib
import io
import logging
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pxr import UsdValidation

from usdio.quiet import quiet
from usdio.stage import open_stage

SIMREADY_PROFILE, SIMREADY_VERSION = "Robotics-Prop", "4.0.0"


class Verdict(NamedTuple):
    """What a judge says: sorted lines `rule: message`. `findings` are failures; without any the package passed."""

    judge: str
    passed: bool
    findings: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def outside_verdicts(main_file: Path) -> tuple[Verdict, ...]:
    """Every outside judge on the package with this main file, silently."""
    return simready(main_file), usd_validation(main_file)


def simready(main_file: Path) -> Verdict:
    """The same answer as `simready-validate --profile Robotics-Prop --version 4.0.0 FILE`.

    Findings are the blocking failures; failures of optional features (joints, grasps, runtime variants) are not
    listed. The package is judged under a link in a plain temporary folder, because NP.003 and NP.004 test every folder
    name up to the disk root and would blame the package for where its user keeps it.
    """
    with _silence(), quiet(), tempfile.TemporaryDirectory(prefix="mana") as place:
        validate = simready_rules()
        package = main_file.resolve().parent.parent
        link = Path(place) / (package.name or "root")
        link.symlink_to(package, target_is_directory=True)
        linked = link / main_file.resolve().relative_to(package)
        result = validate.validate_stage(open_stage(linked), SIMREADY_PROFILE, SIMREADY_VERSION)
    if result is None:
        return Verdict("simready", False, ("the profile could not be loaded",))
    findings = {_issue_line(issue).replace(str(link), package.name) for issue in result.issues}
    return Verdict("simready", validate.features_summary_passed(result.features_summary), tuple(sorted(findings)))


def usd_validation(main_file: Path) -> Verdict:
    """Every validator of `pxr.UsdValidation` but the USDZ ones, in sorted order (the registry's own order varies)."""
    with quiet():
        stage = open_stage(main_file)
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        chosen = [v for v in validators if "UsdzValidators" not in v.GetMetadata().GetKeywords()]
        found = [error for error in UsdValidation.ValidationContext(chosen).Validate(stage) if not error.HasNoError()]
    failures, warnings = set(), set()
    for error in found:
        failed = error.GetType() == UsdValidation.ValidationErrorType.Error
        (failures if failed else warnings).add(f"{error.GetIdentifier()}: {error.GetMessage()}")
    return Verdict("usd-validation", not failures, tuple(sorted(failures)), tuple(sorted(warnings)))


@cache
def simready_rules() -> Any:
    """The SimReady module with its rules loaded (about 1 s, once per process)."""
    import simready.validate

    simready.validate.initialize(rules_and_requirements_paths=[], features_paths=[], profiles_paths=[])
    return simready.validate


def _issue_line(issue: Any) -> str:
    code = issue.requirement.code if issue.requirement is not None else "unnamed"
    return f"{code}: {issue.message}"


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """No console output: SimReady logs to the root logger and prints from some rules."""
    previous = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            yield
    finally:
        logging.disable(previous)

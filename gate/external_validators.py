"""Verdicts of external validators on a released package: NVIDIA's SimReady Foundation and OpenUSD's own validators."""

from __future__ import annotations

import contextlib
import io
import logging
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pxr import UsdValidation

from gate.subject.shading import is_material_x, is_mdl, shader_id
from schemas.diagnostics import InvalidInput
from usdio.quiet import quiet
from usdio.stage import open_stage

SIMREADY, USD_VALIDATION = "simready", "usd-validation"
_SDR = "usdShadeValidators:ShaderSdrCompliance"
_UNREGISTERED = (f"{_SDR}.MissingShaderIdInRegistry", f"{_SDR}.MissingSourceTypeInRegistry")
SIMREADY_PROFILE, SIMREADY_VERSION = "Robotics-Prop", "4.0.0"


class ValidatorIssue(NamedTuple):
    """One issue that a validator reports: its rule, its message, and the prim concerned ("" for the whole file)."""

    rule: str
    message: str
    prim: str = ""

    def __str__(self) -> str:
        return f"{self.rule}: {self.message}"


class ValidatorVerdict(NamedTuple):
    """The verdict of one validator, issues sorted. `findings` are failures; without any the package passed."""

    validator: str
    passed: bool
    findings: tuple[ValidatorIssue, ...] = ()
    warnings: tuple[ValidatorIssue, ...] = ()


def external_verdicts(main_file: Path) -> tuple[ValidatorVerdict, ...]:
    """The verdict of every validator on the package with this main file, without console output.

    A validator that raises has not passed the file: its error is its finding. Raises InvalidInput
    (`asset/package-invalid`) when the file cannot be opened.
    """
    return tuple(_run_validator(name, validate, main_file) for name, validate in VALIDATORS)


def _run_validator(name: str, validate: Callable[[Path], ValidatorVerdict], main_file: Path) -> ValidatorVerdict:
    try:
        return validate(main_file)
    except InvalidInput:  # No file to judge.
        raise
    except Exception as error:  # Code of others, on any file.
        message = f"the judge itself fails on this file: {type(error).__name__}: {error}"[:300]
        return ValidatorVerdict(name, False, (ValidatorIssue("unjudged", message),))


def simready(main_file: Path) -> ValidatorVerdict:
    """The same verdict as `simready-validate --profile Robotics-Prop --version 4.0.0 FILE`.

    Findings are the blocking failures; for the others see `simready_optional`.
    """
    result, places = _simready_result(main_file)
    if result is None:
        return ValidatorVerdict(SIMREADY, False, (ValidatorIssue("unjudged", "the profile could not be loaded"),))
    findings = tuple(sorted({_issue(issue, places) for issue in result.issues}))
    return ValidatorVerdict(SIMREADY, simready_rules().features_summary_passed(result.features_summary), findings)


def simready_optional(main_file: Path) -> tuple[ValidatorIssue, ...]:
    """Failures of optional features (joints, grasps, runtime variants), which every package has some of; sorted."""
    result, places = _simready_result(main_file)
    return () if result is None else tuple(sorted({_issue(issue, places) for issue in result.soft_issues}))


def _simready_result(main_file: Path) -> tuple[Any, dict[str, str]]:
    """SimReady's result, and the folder names that replace the temporary folders in its messages.

    The package is judged under a link in a plain temporary folder, because NP.003 and NP.004 test every folder name up
    to the disk root and would blame the package for where its user keeps it.
    """
    with _silence(), quiet(), tempfile.TemporaryDirectory(prefix="mana") as place:
        package = main_file.resolve().parent.parent
        link = Path(place) / (package.name or "root")
        link.symlink_to(package, target_is_directory=True)
        linked = link / main_file.resolve().relative_to(package)
        result = simready_rules().validate_stage(open_stage(linked), SIMREADY_PROFILE, SIMREADY_VERSION)
    return result, {str(link): package.name}


def usd_validation(main_file: Path) -> ValidatorVerdict:
    """Every validator of `pxr.UsdValidation` but the USDZ ones, in sorted order (the registry's own order varies).

    The usd-core wheel has no registry of MaterialX nodes and MDL materials, so that it calls each of them missing; our
    gate (shader-node) looks them up instead.
    """
    with quiet():
        stage = open_stage(main_file)
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        chosen = [v for v in validators if "UsdzValidators" not in v.GetMetadata().GetKeywords()]
        errors = [error for error in UsdValidation.ValidationContext(chosen).Validate(stage) if not error.HasNoError()]
    errors = [error for error in errors if not _lacks_registry(error)]
    failures, warnings = set(), set()
    for error in errors:
        failed = error.GetType() == UsdValidation.ValidationErrorType.Error
        prims = [site.GetPrim() if site.IsPrim() else site.GetProperty() for site in error.GetSites()]
        paths = [str(prim.GetPath()) for prim in prims if prim]
        message = error.GetMessage().replace(f"{main_file.parent}/", "")
        (failures if failed else warnings).add(ValidatorIssue(error.GetIdentifier(), message, *paths[:1]))
    return ValidatorVerdict(USD_VALIDATION, not failures, tuple(sorted(failures)), tuple(sorted(warnings)))


def _lacks_registry(error: Any) -> bool:
    """Whether an error only says that a shader is of a kind for which this OpenUSD has no registry."""
    if error.GetIdentifier() not in _UNREGISTERED:
        return False
    prims = [site.GetPrim() or site.GetProperty().GetPrim() for site in error.GetSites()]
    return all(is_material_x(shader_id(prim)) or is_mdl(prim) for prim in prims)


@cache
def simready_rules() -> Any:
    """The SimReady module with its rules loaded (about 1 s, once per process)."""
    import simready.validate

    simready.validate.initialize(rules_and_requirements_paths=[], features_paths=[], profiles_paths=[])
    return simready.validate


def _issue(issue: Any, places: dict[str, str]) -> ValidatorIssue:
    """An issue; the temporary folders in `places` are replaced by their package names."""
    message = issue.message
    for place, name in places.items():
        message = message.replace(place, name)
    path = getattr(issue.at, "path", None)
    code = issue.requirement.code if issue.requirement is not None else "unnamed"
    return ValidatorIssue(code, message, "" if path is None else str(path))


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


VALIDATORS: tuple[tuple[str, Callable[[Path], ValidatorVerdict]], ...] = (
    (SIMREADY, simready),
    (USD_VALIDATION, usd_validation),
)

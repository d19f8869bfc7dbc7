"""Read a runtime plan from its JSON file; refuse it if damaged, of another version, or older than its packages."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from pydantic import ValidationError

from runtime_plan.plan import Plan, prepare
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.scene.runtime_plan import SCHEMA_VERSION, RuntimePlan


def load(path: Path | str, packages: Path | str | None = None) -> Plan:
    """The plan in the file `path`, ready to be sampled.

    With `packages`, the folder of the packages it was made from, their records must be the same bytes. Raises
    InvalidInput: `plan/missing-file`, `plan/unreadable`, `plan/unknown-version`, `plan/invalid-value`,
    `plan/inconsistent`, `plan/missing-package`, `plan/changed-package`.
    """
    path = Path(path)
    here = Location(file=path.name)
    if not path.is_file():
        raise InvalidInput(finding("plan/missing-file", f"there is no file {path}", where=here))
    data = path.read_bytes()
    try:
        content = json.loads(data)
        version = content["schema_version"]
        major = int(str(version).split(".")[0])
    except (ValueError, TypeError, KeyError, RecursionError) as wrong:
        reason = "it has no `schema_version`" if isinstance(wrong, TypeError | KeyError) else str(wrong)
        raise InvalidInput(finding("plan/unreadable", f"{path.name} is no plan: {reason}", where=here)) from None
    known = int(SCHEMA_VERSION.split(".")[0])
    if major != known:
        text = f"{path.name} has version {version}; this Mana reads {known}.x"
        raise InvalidInput(finding("plan/unknown-version", text, where=here, value=str(version), bound=SCHEMA_VERSION))
    try:
        document = RuntimePlan.model_validate_json(data)
    except ValidationError as refused:
        first = refused.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        text = f"{path.name}: {place}: {first['msg']}"
        raise InvalidInput(finding("plan/invalid-value", text, where=here)) from None
    plan = prepare(document, hashlib.sha256(data).hexdigest())
    if packages is not None:
        _same_packages(document, Path(packages))
    return plan


def _same_packages(document: RuntimePlan, folder: Path) -> None:
    for body in document.bodies:
        if body.package is None:
            continue
        record = folder / body.package / "record.json"
        where = Location(file=f"{body.package}/record.json")
        if not record.is_file():
            text = f"the package {body.package} of the plan is not in {folder}"
            raise InvalidInput(finding("plan/missing-package", text, where=where))
        sha256 = hashlib.sha256(record.read_bytes()).hexdigest()
        if body.package_hash is not None and sha256 != body.package_hash:
            text = f"the package {body.package} is not the one that the plan was made from"
            raise InvalidInput(
                finding("plan/changed-package", text, where=where, value=sha256[:12], bound=body.package_hash[:12])
            )

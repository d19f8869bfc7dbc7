"""Stage 4, semantics: what the object is. Only what the user or the file says; unknown stays unknown."""

from __future__ import annotations

from pathlib import Path

from assetkit.stage import Draft, Semantics, Stage, Tools
from schemas.asset import SemanticsSection
from schemas.evidence import declared, default
from schemas.outcome import Outcome

UNKNOWN = "unknown"
PHYSICAL_OBJECT_QCODE = "Q488383"  # Wikidata "object": true of every asset, claims nothing more.


class DescribeObject(Stage):
    """Records category, role and name as stated by flags; a later annotator refines them."""

    name = "semantics"
    version = 1
    result = Semantics

    def run(self, draft: Draft, tools: Tools) -> Outcome[Semantics]:
        """Category, roles and qcode with their evidence."""
        options = tools.options
        section = SemanticsSection(
            name=Path(draft.source_name).stem,
            category=declared(options.category, "--category") if options.category else default(UNKNOWN),
            roles=(declared(options.role, "--role"),) if options.role else (),
            qcode=default(PHYSICAL_OBJECT_QCODE, "most general class"),
        )
        return Outcome(Semantics(section))

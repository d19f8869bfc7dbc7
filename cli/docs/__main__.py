"""Write every generated page of the documentation: `python -m cli.docs` (or `make docs`).

The pages come from tables in the code: diagnostic codes, rules of the gate, effects, source formats, relations,
predicates.
`generated_pages` is the whole list; a test compares it with the files in `docs/`.
"""

from __future__ import annotations

from pathlib import Path

from cli.docs import diagnostics, effects, formats, gate, material_features, paired_materials, predicates, relations

DOCS = Path("docs")
DIAGNOSTICS = Path("diagnostics")


def generated_pages() -> dict[Path, str]:
    """Text of each generated page by its path below `docs/`."""
    codes = {DIAGNOSTICS / name: text for name, text in diagnostics.pages().items()}
    return {
        **codes,
        Path("reference/gate.md"): gate.page(),
        Path("reference/effects.md"): effects.page(),
        Path("reference/file-formats.md"): formats.page(),
        Path("reference/material-features.md"): material_features.page(),
        Path("reference/paired-materials.md"): paired_materials.page(),
        Path("reference/predicates.md"): predicates.page(),
        Path("reference/relations.md"): relations.page(),
    }


def write(docs: Path) -> None:
    """Write the pages below `docs`; pages of diagnostic codes that no longer exist are removed."""
    pages = generated_pages()
    for stale in (docs / DIAGNOSTICS).glob("*.md"):
        if stale.relative_to(docs) not in pages:
            stale.unlink()
    for path, text in pages.items():
        (docs / path).parent.mkdir(parents=True, exist_ok=True)
        (docs / path).write_text(text)


if __name__ == "__main__":
    write(DOCS)

"""Write `docs/diagnostics/` from the table of codes: `python -m cli.docs.diagnostics [DIR]`."""

from __future__ import annotations

import sys
from pathlib import Path

from schemas.codes import CODES, CodeInfo


def page(code: str, info: CodeInfo) -> str:
    """The page of one code."""
    return (
        f"# {code}\n\n**{info.title}.** Severity: {info.severity}.\n\n"
        f"## Why it matters\n\n{info.why}\n\n## What to do\n\n{info.help[0].upper()}{info.help[1:]}.\n"
    )


def index() -> str:
    """The list of all codes."""
    rows = "\n".join(
        f"| [{code}]({file_name(code)}) | {info.severity} | {info.title} |" for code, info in sorted(CODES.items())
    )
    return (
        "# Diagnostics\n\nEvery finding carries one of these codes. Codes are stable.\n\n"
        f"| code | severity | what was found |\n|---|---|---|\n{rows}\n"
    )


def file_name(code: str) -> str:
    """The file of a code's page."""
    return f"{code.replace('/', '-')}.md"


def write(folder: Path) -> None:
    """Write the index and one page per code; pages of codes that no longer exist are removed."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {file_name(code): page(code, info) for code, info in CODES.items()} | {"index.md": index()}
    for stale in folder.glob("*.md"):
        if stale.name not in wanted:
            stale.unlink()
    for name, text in wanted.items():
        (folder / name).write_text(text)


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/diagnostics"))

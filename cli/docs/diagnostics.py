"""Pages of `docs/diagnostics/` from all codes: an index, and one page per code."""

from __future__ import annotations

from cli.codes import all_codes
from schemas.codes.code_info import CodeInfo


def page(code: str, info: CodeInfo) -> str:
    """The page of one code."""
    return (
        f"# {code}\n\n**{info.title}.** Severity: {info.severity}.\n\n"
        f"## Why it matters\n\n{info.why}\n\n## What to do\n\n{info.help[0].upper()}{info.help[1:]}.\n"
    )


def index() -> str:
    """The list of all codes."""
    codes = sorted(all_codes().items())
    rows = "\n".join(f"| [{code}]({file_name(code)}) | {info.severity} | {info.title} |" for code, info in codes)
    return (
        "# Diagnostics\n\nEvery finding carries one of these codes. Codes are stable.\n\n"
        f"| code | severity | what was found |\n|---|---|---|\n{rows}\n"
    )


def file_name(code: str) -> str:
    """The file of a code's page."""
    return f"{code.replace('/', '-')}.md"


def pages() -> dict[str, str]:
    """Text by file name: the index and one page per code."""
    return {file_name(code): page(code, info) for code, info in all_codes().items()} | {"index.md": index()}

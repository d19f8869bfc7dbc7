"""Opens a page from disk in a headless Chromium and runs a script in it, as a reader would use it."""

from __future__ import annotations

import json
import re
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

from tests.support.peers import chromium

BUDGET_MS = 20_000  # of the page's own clock, which runs as fast as the page allows
_ANSWER = re.compile(r'<pre id="answer-of-the-test">(.*?)</pre>', re.DOTALL)
# Counts what only script of somebody else can do in a page of ours, from before the page's first line.
_WATCH = (
    "<script>window.hijacked = [];"
    "for (const name of ['alert', 'confirm', 'prompt', 'open'])"
    " window[name] = (...words) => { window.hijacked.push([name, ...words.map(String)]); };</script>"
)


def answer_of_page(page: Path, script: str) -> Any:
    """What the body of an async function returns in the page, from JSON; `hijacked` lists calls of dialogs.

    A copy of the page with the script lies beside it meanwhile, since pages load their files by relative paths.
    """
    program = chromium()
    source = page.read_text(encoding="utf-8")
    asked = (
        f"<script>(async () => {{ {script} }})().catch(error => ({{ error: String(error) }})).then(answer => {{"
        " const place = document.createElement('pre'); place.id = 'answer-of-the-test';"
        " place.textContent = JSON.stringify(answer); document.body.append(place); }});</script>"
    ).replace("}});", "});")
    before, head, after = source.partition("<head>")
    body, end, rest = after.rpartition("</body>")
    assert (head, end) == ("<head>", "</body>")
    copy = page.with_name(f"asked-{page.name}")
    copy.write_text(f"{before}{head}{_WATCH}{body}{asked}{end}{rest}", encoding="utf-8")
    command = [program, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1400,900"]
    profile = page.parent / ".browser"
    command += [f"--user-data-dir={profile}", f"--virtual-time-budget={BUDGET_MS}", "--dump-dom", copy.as_uri()]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    finally:
        copy.unlink()
    found = _ANSWER.search(done.stdout)
    assert found is not None, f"the page gave no answer: {done.stderr[-1500:]}"
    answer = json.loads(unescape(found[1]))
    assert not (isinstance(answer, dict) and "error" in answer), answer
    return answer

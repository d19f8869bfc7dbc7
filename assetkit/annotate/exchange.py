"""Sends one request to an endpoint over HTTP, bounded in time, size and attempts.

Run in a cell (`python -m assetkit.annotate.exchange POST REPLY`), because servers hang and names may never resolve. The
key is read from the environment here and nowhere else: it is in no file, no argument and no answer.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
import urllib.error
import urllib.request
from http.client import HTTPException
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict

from jobs.cell import Limits
from jobs.warm import run_module

KEY_VARIABLE = "MANA_ANNOTATOR_KEY"
MAX_ANSWER_BYTES = 2**20  # An answer is some hundred bytes.
ATTEMPTS = 3
MAX_WAIT_S = 20.0
_BUSY = frozenset((408, 425, 429, 500, 502, 503, 504, 529))
_CLOSED = frozenset((401, 403, 404))
_SPARE_S, _EXCHANGE_MEMORY_MB = 10.0, 2048
_CHUNK = 2**16


class Post(BaseModel):
    """A request. The key goes into `key_header`, if any, behind `key_prefix`; `seconds` bounds each attempt."""

    model_config = ConfigDict(frozen=True)

    url: str
    body: dict[str, Any]
    key_header: str = ""
    key_prefix: str = ""
    seconds: float
    wait_s: float = 1.0


class Reply(BaseModel):
    """`text` of an answer with `status` 200, else the reason as `failure`, and the endpoint's own words as `text`.

    `status` is 0 when the endpoint sent nothing.
    """

    model_config = ConfigDict(frozen=True)

    text: str = ""
    status: int = 0
    failure: str = ""
    attempts: int = 0

    @property
    def unreachable(self) -> bool:
        """Whether another request would fail alike."""
        return self.failure != "" and self.status in {0, *_BUSY, *_CLOSED}


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A redirect would carry the key to another host."""

    def redirect_request(self, req: Any, fp: Any, code: Any, msg: Any, headers: Any, newurl: Any) -> None:
        return None


_OPENER = urllib.request.build_opener(_NoRedirect)


def exchange(post: Post, key: str) -> Reply:
    """The reply after at most `ATTEMPTS`; busy, silent and unreachable endpoints are tried again after a wait.

    Waits grow fourfold from `wait_s`; `Retry-After` is respected up to `MAX_WAIT_S`. Never raises for what the
    endpoint does. The key is blotted out of what comes back.
    """
    if not (key.isascii() and key.isprintable()):  # `http.client` would quote it in its error.
        return Reply(failure=f"the key in {KEY_VARIABLE} cannot be sent")
    reply, retry_after = Reply(), None
    for attempt in range(ATTEMPTS):
        if attempt:
            wait = post.wait_s * 4.0 ** (attempt - 1) if retry_after is None else retry_after
            time.sleep(min(wait, MAX_WAIT_S))
        reply, retry_after = _attempt(post, key)
        reply = reply.model_copy(update={"attempts": attempt + 1})
        if reply.status and reply.status not in _BUSY:
            break
    return reply


def _attempt(post: Post, key: str) -> tuple[Reply, float | None]:
    """The reply, and the seconds of `Retry-After` where the endpoint sends it."""
    headers = {"Content-Type": "application/json", "Accept": "application/json"}
    if key and post.key_header:
        headers[post.key_header] = post.key_prefix + key
    request = urllib.request.Request(post.url, json.dumps(post.body).encode(), headers, method="POST")
    deadline = time.monotonic() + post.seconds
    try:
        try:
            with _OPENER.open(request, timeout=post.seconds) as response:
                return _read(response, response.status, key, deadline), None
        except urllib.error.HTTPError as refusal:
            with refusal:
                reply = _read(refusal, refusal.code, key, deadline)
                return reply, _seconds(refusal.headers.get("Retry-After"))
    except TimeoutError:
        return Reply(failure=f"no answer within {post.seconds:g} s"), None
    except urllib.error.URLError as error:
        late = isinstance(error.reason, TimeoutError)
        failure = f"no answer within {post.seconds:g} s" if late else f"not reached: {_blotted(str(error.reason), key)}"
        return Reply(failure=failure), None
    except (OSError, HTTPException) as error:
        return Reply(failure=f"the connection broke: {type(error).__name__}"), None
    except ValueError:  # A host name that is none, or a redirect to one.
        return Reply(failure="the address is none"), None


def _read(response: Any, status: int, key: str, deadline: float) -> Reply:
    """At most `MAX_ANSWER_BYTES`, until `deadline`. Raises TimeoutError after it."""
    data = b""
    while chunk := response.read1(_CHUNK):
        data += chunk
        if len(data) > MAX_ANSWER_BYTES:
            return Reply(status=status, failure=f"the answer is larger than {MAX_ANSWER_BYTES} bytes")
        if time.monotonic() > deadline:
            raise TimeoutError
    text = _blotted(data.decode(errors="replace"), key)
    return Reply(text=text, status=status, failure="" if status == 200 else f"status {status}")


def _blotted(text: str, key: str) -> str:
    return text.replace(key, "***") if key else text


def _seconds(header: str | None) -> float | None:
    return float(header) if header is not None and header.isascii() and header.isdigit() else None


def worst_seconds(seconds: float) -> float:
    """How long an exchange may take when each attempt may take `seconds`."""
    return ATTEMPTS * seconds + (ATTEMPTS - 1) * MAX_WAIT_S


def exchange_in_cell(post: Post, work_dir: Path) -> Reply:
    """As `exchange`, with the key of the environment, in a cell that is stopped when it hangs."""
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as folder:
        post_file, reply_file = Path(folder) / "post.json", Path(folder) / "reply.json"
        post_file.write_text(post.model_dump_json())
        limits = Limits(worst_seconds(post.seconds) + _SPARE_S, _EXCHANGE_MEMORY_MB)
        result = run_module("assetkit.annotate.exchange", [str(post_file), str(reply_file)], limits)
        if result.status != "ok" or not reply_file.is_file():
            return Reply(failure=f"asking {result.status.replace('_', ' ')}", attempts=1)
        return Reply.model_validate_json(reply_file.read_bytes())


def main(post_file: str, reply_file: str) -> None:
    """Send the request in `post_file`, write the reply to `reply_file`."""
    post = Post.model_validate_json(Path(post_file).read_bytes())
    key = os.environ.get(KEY_VARIABLE, "").strip()
    Path(reply_file).write_text(exchange(post, key).model_dump_json())


if __name__ == "__main__":
    main(*sys.argv[1:3])

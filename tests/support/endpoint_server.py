"""A model's endpoint on this machine that answers by a script: well, badly, late, at length, or with malice."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, NamedTuple

Respond = Callable[[BaseHTTPRequestHandler], None]


class Request(NamedTuple):
    """One request as it came over the wire."""

    path: str
    headers: dict[str, str]
    body: str


class Server(NamedTuple):
    """`url` of the server; `script` is used up from the front, its last entry stays; `requests` collects what came."""

    url: str
    script: list[Respond]
    requests: list[Request]


@contextmanager
def endpoint(*script: Respond) -> Iterator[Server]:
    """A server that answers by `script` until the context ends."""
    state = Server("", list(script), [])

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"])).decode()
            headers = {name.lower(): value for name, value in self.headers.items()}
            state.requests.append(Request(self.path, headers, body))
            respond = state.script.pop(0) if len(state.script) > 1 else state.script[0]
            with suppress(OSError):  # The client hung up.
                respond(self)

        def log_message(self, format: str, *args: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
    try:
        yield state._replace(url=f"http://127.0.0.1:{server.server_address[1]}/v1")
    finally:
        server.shutdown()
        server.server_close()


def answer(*, roles: dict[str, float] | None = None, description: str = "A vessel.", **categories: float) -> str:
    """The text of an answer that keeps the schema."""
    ranked = [{"category": name, "confidence": chance} for name, chance in categories.items()]
    ranked_roles = [{"role": name, "confidence": chance} for name, chance in (roles or {}).items()]
    return json.dumps({"categories": ranked, "roles": ranked_roles, "description": description})


def openai(text: str | None, finish: str = "stop") -> str:
    """`text` as chat completions wrap it, with 1000 tokens in and 50 out."""
    choice = {"index": 0, "message": {"role": "assistant", "content": text}, "finish_reason": finish}
    usage = {"prompt_tokens": 1000, "completion_tokens": 50, "total_tokens": 1050}
    return json.dumps({"id": "x", "object": "chat.completion", "choices": [choice], "usage": usage})


def gemini(text: str) -> str:
    """`text` as generateContent wraps it, cut into two parts behind a thought, with 1000 tokens in and 50 out."""
    half = len(text) // 2
    parts = [{"text": "it looks round", "thought": True}, {"text": text[:half]}, {"text": text[half:]}]
    usage = {"promptTokenCount": 1000, "candidatesTokenCount": 30, "thoughtsTokenCount": 20}
    candidate = {"content": {"role": "model", "parts": parts}, "finishReason": "STOP"}
    return json.dumps({"candidates": [candidate], "usageMetadata": usage, "modelVersion": "x"})


def says(body: str, status: int = 200, **headers: str) -> Respond:
    """Answer with this body."""

    def respond(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(status)
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.send_header("Content-Length", str(len(body.encode())))
        handler.end_headers()
        handler.wfile.write(body.encode())

    return respond


def silent(seconds: float) -> Respond:
    """Say nothing for a while, then hang up."""
    return lambda handler: time.sleep(seconds)


def dripping(seconds: float) -> Respond:
    """A blank every few milliseconds, so that no single read ever takes long."""

    def respond(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(200)
        handler.end_headers()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            handler.wfile.write(b" ")
            handler.wfile.flush()
            time.sleep(0.01)

    return respond


def endless() -> Respond:
    """Megabytes without end."""

    def respond(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(200)
        handler.end_headers()
        while True:
            handler.wfile.write(b"x" * 2**16)

    return respond

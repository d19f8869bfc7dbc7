"""The annotator that looks: it shows a model the four standard views and weighs the answer against names and shape."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import Annotation, Annotator, Asked, Observation
from assetkit.annotate.answer import read_answer
from assetkit.annotate.dialects import DIALECTS, Said
from assetkit.annotate.exchange import Post, Reply
from assetkit.annotate.question import PROMPT_VERSION, Question, cleaned, question
from assetkit.annotate.weigh import weigh
from assetkit.options import Endpoint
from jobs.cache import Cache, content_key, write_atomically
from schemas.asset import EndpointAnswer
from schemas.diagnostics import finding
from schemas.outcome import EndpointUse

UNREACHABLE = "asset/annotator-unreachable"
_MAX_TOLD = 200
_BAD_REQUEST = 400


class _Kept(BaseModel):
    """A usable answer in the store, as the model gave it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    text: str
    settings: dict[str, float]


@dataclass(frozen=True)
class MultimodalAnnotator:
    """Asks `endpoint` by `send`; without a usable answer what `embedded` says stands, and a finding tells it.

    Usable answers are kept in `store` by the content of the question, so that the same pictures are never paid twice.
    """

    endpoint: Endpoint
    embedded: Annotator
    send: Callable[[Post], Reply]
    store: Cache | None = None

    def annotate(self, observation: Observation) -> Annotation:
        """The weighed annotation; never raises for what the endpoint does."""
        embedded = self.embedded.annotate(observation)
        asked = self._ask(question(observation, embedded))
        return weigh(embedded, asked, observation.shape)

    def _ask(self, asked: Question) -> Asked:
        file = self._file(asked)
        if file is not None and (kept := self._recall(file)) is not None:
            return _asked(kept, EndpointUse(from_store=1))
        dialect = DIALECTS[self.endpoint.kind]
        settings, reply, requests = dict(dialect.settings), Reply(), 0
        for _ in range(len(dialect.settings) + 1):
            reply = self.send(dialect.post(self.endpoint, asked, settings))
            requests += reply.attempts
            # Some models fix their own settings and say so; endpoints name one at a time.
            unknown = [s for s in settings if s in reply.text] if reply.status == _BAD_REQUEST else []
            if not unknown:
                break
            settings = {name: value for name, value in settings.items() if name not in unknown}
        use = EndpointUse(requests=requests)
        if reply.failure:
            code = UNREACHABLE if reply.unreachable else "asset/annotator-failed"
            return self._failed(code, f"{reply.failure} {_quoted(reply.text)}".strip(), use)
        try:
            said = dialect.said(reply.text)
            use = self._priced(said, requests)
            answer = self._answer(said.text, settings)
        except ValueError:
            why = f"the answer does not keep the schema {_quoted(reply.text)}".strip()
            return self._failed("asset/annotator-failed", why, use)
        if file is not None:
            kept = _Kept(text=said.text, settings=settings)
            write_atomically(file, kept.model_dump_json().encode("utf-8", "surrogatepass"))
        return _asked(answer, use)

    def _file(self, asked: Question) -> Path | None:
        """Where the answer lies or would lie; None without a store."""
        if self.store is None:
            return None
        post = DIALECTS[self.endpoint.kind].post(self.endpoint, asked, DIALECTS[self.endpoint.kind].settings)
        key = content_key(self.endpoint.kind, PROMPT_VERSION, post.url, post.body)
        return self.store.path("answers", key, ".json")

    def _recall(self, file: Path) -> EndpointAnswer | None:
        """A kept answer, or None; one that is damaged counts as none."""
        try:
            kept = _Kept.model_validate_json(file.read_bytes())
            return self._answer(kept.text, kept.settings)
        except (OSError, ValueError):
            return None

    def _answer(self, text: str, settings: Mapping[str, float]) -> EndpointAnswer:
        return read_answer(text, f"{self.endpoint.model}, prompt {PROMPT_VERSION}", settings)

    def _priced(self, said: Said, requests: int) -> EndpointUse:
        price = self.endpoint.usd_per_million
        usd = None if price is None else (said.input_tokens * price[0] + said.output_tokens * price[1]) / 1e6
        return EndpointUse(requests=requests, input_tokens=said.input_tokens, output_tokens=said.output_tokens, usd=usd)

    def _failed(self, code: str, why: str, use: EndpointUse) -> Asked:
        headline = f"{self.endpoint.model} gave no usable answer: {why}"
        return Asked(None, use, (finding(code, headline),))


def _asked(answer: EndpointAnswer, use: EndpointUse) -> Asked:
    if not answer.refused:
        return Asked(answer, use)
    headline = f"{answer.method} named what is not in the vocabulary; it is left out"
    return Asked(answer, use, (finding("asset/annotator-refused", headline, value=json.dumps(answer.refused)),))


def _quoted(text: str) -> str:
    return f"({cleaned(text, _MAX_TOLD)})" if text.strip() else ""

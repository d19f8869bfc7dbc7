"""The annotator that sends four standard views to a model and weighs its answer against names and shape."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from assetkit.annotate.annotator import Annotation, Annotator, EndpointResult, Observation
from assetkit.annotate.answer import read_answer
from assetkit.annotate.dialects import DIALECTS, Completion
from assetkit.annotate.exchange import Post, Reply
from assetkit.annotate.prompt import PROMPT_VERSION, Prompt, cleaned, prompt_for
from assetkit.annotate.weigh import weigh
from assetkit.options import Endpoint
from jobs.cache import Cache, content_key, write_atomically
from schemas.asset import EndpointAnswer
from schemas.diagnostics import finding
from schemas.outcome import EndpointUse

UNREACHABLE = "asset/annotator-unreachable"
_MAX_QUOTE = 200
_BAD_REQUEST = 400


class _StoredAnswer(BaseModel):
    """A usable answer in the store, as the model gave it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    text: str
    settings: dict[str, float]


@dataclass(frozen=True)
class MultimodalAnnotator:
    """Queries `endpoint` by `send`; without a usable answer the annotation of `embedded` is kept, with a finding.

    Usable answers are stored by the content of the prompt, so that the same pictures are never paid twice.
    """

    endpoint: Endpoint
    embedded: Annotator
    send: Callable[[Post], Reply]
    store: Cache | None = None

    def annotate(self, observation: Observation) -> Annotation:
        """The weighed annotation; never raises for what the endpoint does."""
        embedded = self.embedded.annotate(observation)
        result = self._query(prompt_for(observation, embedded))
        return weigh(embedded, result, observation.shape)

    def _query(self, prompt: Prompt) -> EndpointResult:
        file = self._file(prompt)
        if file is not None and (stored := self._recall(file)) is not None:
            return _result_of(stored, EndpointUse(from_store=1))
        dialect = DIALECTS[self.endpoint.kind]
        settings, reply, requests = dict(dialect.settings), Reply(), 0
        for _ in range(len(dialect.settings) + 1):
            reply = self.send(dialect.post(self.endpoint, prompt, settings))
            requests += reply.attempts
            # Some models reject settings that they fix themselves; endpoints name one at a time.
            unknown = [s for s in settings if s in reply.text] if reply.status == _BAD_REQUEST else []
            if not unknown:
                break
            settings = {name: value for name, value in settings.items() if name not in unknown}
        use = EndpointUse(requests=requests)
        if reply.failure:
            code = UNREACHABLE if reply.unreachable else "asset/annotator-failed"
            return self._failed(code, f"{reply.failure} {_quoted(reply.text)}".strip(), use)
        try:
            completion = dialect.completion(reply.text)
            use = self._priced(completion, requests)
            answer = self._answer(completion.text, settings)
        except ValueError:
            why = f"the answer does not keep the schema {_quoted(reply.text)}".strip()
            return self._failed("asset/annotator-failed", why, use)
        if file is not None:
            entry = _StoredAnswer(text=completion.text, settings=settings)
            write_atomically(file, entry.model_dump_json().encode("utf-8", "surrogatepass"))
        return _result_of(answer, use)

    def _file(self, prompt: Prompt) -> Path | None:
        """Where the answer lies or would lie; None without a store."""
        if self.store is None:
            return None
        post = DIALECTS[self.endpoint.kind].post(self.endpoint, prompt, DIALECTS[self.endpoint.kind].settings)
        key = content_key(self.endpoint.kind, PROMPT_VERSION, post.url, post.body)
        return self.store.path("answers", key, ".json")

    def _recall(self, file: Path) -> EndpointAnswer | None:
        """A stored answer, or None; one that is damaged counts as none."""
        try:
            stored = _StoredAnswer.model_validate_json(file.read_bytes())
            return self._answer(stored.text, stored.settings)
        except (OSError, ValueError):
            return None

    def _answer(self, text: str, settings: Mapping[str, float]) -> EndpointAnswer:
        return read_answer(text, f"{self.endpoint.model}, prompt {PROMPT_VERSION}", settings)

    def _priced(self, completion: Completion, requests: int) -> EndpointUse:
        price = self.endpoint.usd_per_million
        usd = (
            None if price is None else (completion.input_tokens * price[0] + completion.output_tokens * price[1]) / 1e6
        )
        return EndpointUse(
            requests=requests, input_tokens=completion.input_tokens, output_tokens=completion.output_tokens, usd=usd
        )

    def _failed(self, code: str, why: str, use: EndpointUse) -> EndpointResult:
        headline = f"{self.endpoint.model} gave no usable answer: {why}"
        return EndpointResult(None, use, (finding(code, headline),))


def _result_of(answer: EndpointAnswer, use: EndpointUse) -> EndpointResult:
    if not answer.refused:
        return EndpointResult(answer, use)
    headline = f"{answer.method} named what is not in the vocabulary; it is left out"
    return EndpointResult(
        answer, use, (finding("asset/annotator-refused", headline, value=json.dumps(answer.refused)),)
    )


def _quoted(text: str) -> str:
    return f"({cleaned(text, _MAX_QUOTE)})" if text.strip() else ""

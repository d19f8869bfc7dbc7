"""Requests and replies of endpoint protocols: OpenAI's chat completions and Gemini's generateContent.

Sources: the API references of OpenAI (`/v1/chat/completions`, structured outputs) and Google (`generateContent`,
`responseSchema`). Settings are fixed, so that an endpoint that can be deterministic is.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol
from urllib.parse import quote

from pydantic import BaseModel, ConfigDict, Field

from assetkit.annotate.exchange import Post
from assetkit.annotate.prompt import Prompt
from assetkit.options import Endpoint

_MAX_TOKENS = 4096  # Models that think aloud need some thousand.
_Tokens = Annotated[int, Field(ge=0, le=10**9)]
Settings = Mapping[str, float]


class Completion(NamedTuple):
    """The text of an answer and the tokens it used."""

    text: str
    input_tokens: int
    output_tokens: int


class Dialect(Protocol):
    """One endpoint protocol. `settings` can be left out one by one when an endpoint does not support them."""

    settings: ClassVar[Settings]

    def post(self, endpoint: Endpoint, prompt: Prompt, settings: Settings) -> Post:
        """The request for `prompt` in the format of this protocol."""
        ...

    def completion(self, reply: str) -> Completion:
        """The completion in a reply. Raises ValueError for anything else than a finished answer."""
        ...


class _Reply(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class _OpenAiMessage(_Reply):
    content: str | None = None


class _OpenAiChoice(_Reply):
    message: _OpenAiMessage
    finish_reason: str | None = None


class _OpenAiUsage(_Reply):
    prompt_tokens: _Tokens = 0
    completion_tokens: _Tokens = 0


class _OpenAiReply(_Reply):
    choices: list[_OpenAiChoice] = Field(min_length=1)
    usage: _OpenAiUsage | None = None


class OpenAi:
    """`/chat/completions` with image parts and a strict `json_schema` response format."""

    settings: ClassVar[Settings] = {"temperature": 0, "seed": 0, "max_completion_tokens": _MAX_TOKENS}

    def post(self, endpoint: Endpoint, prompt: Prompt, settings: Settings) -> Post:
        """The prompt as a system and a user message; the key goes as bearer token."""
        parts: list[dict[str, Any]] = [{"type": "text", "text": prompt.context}]
        for name, png in prompt.pictures:
            picture = {"url": f"data:image/png;base64,{_base64(png)}"}
            parts += [{"type": "text", "text": name}, {"type": "image_url", "image_url": picture}]
        schema = {"name": "object_meaning", "strict": True, "schema": prompt.schema}
        body = {
            "model": endpoint.model,
            "messages": [
                {"role": "system", "content": prompt.instruction},
                {"role": "user", "content": parts},
            ],
            "response_format": {"type": "json_schema", "json_schema": schema},
            **settings,
        }
        url = f"{endpoint.url}/chat/completions"
        return Post(url=url, body=body, key_header="Authorization", key_prefix="Bearer ", seconds=endpoint.seconds)

    def completion(self, reply: str) -> Completion:
        """The content of the first choice."""
        read = _OpenAiReply.model_validate_json(reply)
        choice, usage = read.choices[0], read.usage or _OpenAiUsage()
        if choice.finish_reason not in (None, "stop") or choice.message.content is None:
            raise ValueError(f"the answer ended with {choice.finish_reason!r}")
        return Completion(choice.message.content, usage.prompt_tokens, usage.completion_tokens)


class _GeminiPart(_Reply):
    text: str = ""
    thought: bool = False


class _GeminiContent(_Reply):
    parts: list[_GeminiPart] = []


class _GeminiCandidate(_Reply):
    content: _GeminiContent = _GeminiContent()
    finish_reason: str | None = Field(default=None, alias="finishReason")


class _GeminiUsage(_Reply):
    prompt: _Tokens = Field(default=0, alias="promptTokenCount")
    answer: _Tokens = Field(default=0, alias="candidatesTokenCount")
    thoughts: _Tokens = Field(default=0, alias="thoughtsTokenCount")


class _GeminiReply(_Reply):
    candidates: list[_GeminiCandidate] = Field(min_length=1)
    usage: _GeminiUsage = Field(default=_GeminiUsage(), alias="usageMetadata")


class Gemini:
    """`:generateContent` with inline pictures and `responseSchema`."""

    settings: ClassVar[Settings] = {"temperature": 0, "seed": 0, "maxOutputTokens": _MAX_TOKENS}

    def post(self, endpoint: Endpoint, prompt: Prompt, settings: Settings) -> Post:
        """The prompt as system instruction and one content; the key goes in a header, never in the address."""
        parts: list[dict[str, Any]] = [{"text": prompt.context}]
        for name, png in prompt.pictures:
            parts += [{"text": name}, {"inlineData": {"mimeType": "image/png", "data": _base64(png)}}]
        body = {
            "systemInstruction": {"parts": [{"text": prompt.instruction}]},
            "contents": [{"role": "user", "parts": parts}],
            "generationConfig": {
                "responseMimeType": "application/json",
                "responseSchema": _openapi(prompt.schema),
                **settings,
            },
        }
        url = f"{endpoint.url}/models/{quote(endpoint.model.removeprefix('models/'), safe='')}:generateContent"
        return Post(url=url, body=body, key_header="x-goog-api-key", seconds=endpoint.seconds)

    def completion(self, reply: str) -> Completion:
        """The text of the first candidate, without its thoughts."""
        read = _GeminiReply.model_validate_json(reply)
        candidate, usage = read.candidates[0], read.usage
        if candidate.finish_reason not in (None, "STOP"):
            raise ValueError(f"the answer ended with {candidate.finish_reason!r}")
        text = "".join(part.text for part in candidate.content.parts if not part.thought)
        return Completion(text, usage.prompt, usage.answer + usage.thoughts)


DIALECTS: dict[str, Dialect] = {"openai": OpenAi(), "gemini": Gemini()}


def _openapi(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema in Gemini's subset of OpenAPI: types in capitals, order of properties stated, no closed objects."""
    openapi: dict[str, Any] = {"type": schema["type"].upper()}
    if "enum" in schema:
        openapi |= {"format": "enum", "enum": schema["enum"]}
    if "items" in schema:
        openapi["items"] = _openapi(schema["items"])
    if "properties" in schema:
        openapi["properties"] = {name: _openapi(s) for name, s in schema["properties"].items()}
        openapi |= {"required": schema["required"], "propertyOrdering": schema["required"]}
    return openapi


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()

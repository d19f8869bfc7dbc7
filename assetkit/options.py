"""What the user may say about a batch; part of every cache key."""

from __future__ import annotations

from typing import Literal
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field, field_validator

UnitName = Literal["mm", "cm", "m", "in", "auto"]
UpAxisName = Literal["x", "y", "z", "auto"]
METERS_PER_UNIT: dict[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}


class Endpoint(BaseModel):
    """A model that is shown pictures over the network. The key is no part of it: it stays in the environment."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["openai", "gemini"] = "openai"
    url: str = Field(description="base address, e.g. https://api.openai.com/v1")
    model: str = Field(pattern=r"^[A-Za-z0-9][\w.:/@-]{0,99}$")
    seconds: float = Field(default=40.0, gt=0.0, le=600.0, description="time that one request may take")
    usd_per_million: tuple[float, float] | None = Field(default=None, description="price of input and output tokens")

    @field_validator("url")
    @classmethod
    def _without_secrets(cls, url: str) -> str:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.query or parts.fragment:
            raise ValueError("must be a plain http or https address")
        if parts.username is not None:
            raise ValueError("must hold no key or password: addresses are stored")
        return url.rstrip("/")


class Options(BaseModel):
    """Statements about the assets (they become `declared` evidence) and the budgets of their processing."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    units: UnitName = "auto"
    up_axis: UpAxisName = "auto"
    role: str | None = None
    category: str | None = None
    require_category: bool = Field(default=False, description="an object of unknown category goes to a person")
    endpoint: Endpoint | None = Field(default=None, description="a model to ask what pictures show; None: nobody")
    license: str | None = None
    author: str | None = None
    shell_thickness_m: float | None = Field(default=None, gt=0.0, description="wall thickness of open surfaces")
    max_triangles: int = Field(default=200_000, description="visual triangles above which a mesh is reduced")
    max_objects: int = Field(default=24, description="separate objects in one file above which a person decides")

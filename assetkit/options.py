"""Options of a batch: the user's statements about the assets and limits of processing; part of every cache key."""

from __future__ import annotations

from typing import Literal
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field, field_validator

from schemas.decision import Decision

UnitName = Literal["mm", "cm", "m", "in", "auto"]
UpAxisName = Literal["x", "y", "z", "auto"]
METERS_PER_UNIT: dict[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}


class Endpoint(BaseModel):
    """A model that receives pictures over the network. Its key is not stored here: it stays in the environment."""

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


class SegmenterCommand(BaseModel):
    """A program of the user that proposes parts. `digest` is the hash of its files: a changed program runs again."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    command: tuple[str, ...] = Field(min_length=1)
    seconds: float = Field(default=60.0, gt=0.0, le=3600.0, description="time that one object may take")
    digest: str = ""


class AppearanceGenerator(BaseModel):
    """A program of the user, or the http(s) address of a server, that proposes materials for degraded surfaces.

    `digest` is the hash of the program's files: a changed program runs again.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    command: tuple[str, ...] = ()
    url: str = ""
    seconds: float = Field(default=60.0, gt=0.0, le=600.0, description="time that one object may take")
    digest: str = ""


class Options(BaseModel):
    """Statements about the assets (they become `declared` evidence) and the budgets of their processing."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    units: UnitName = "auto"
    up_axis: UpAxisName = "auto"
    role: str | None = None
    category: str | None = None
    require_category: bool = Field(default=False, description="an object of unknown category goes to a person")
    endpoint: Endpoint | None = Field(default=None, description="a model to ask what pictures show; None: nobody")
    segmenter: SegmenterCommand | None = Field(default=None, description="a program that proposes parts")
    license: str | None = None
    author: str | None = None
    shell_thickness_m: float | None = Field(default=None, gt=0.0, description="wall thickness of open surfaces")
    max_triangles: int = Field(default=200_000, description="visual triangles above which a mesh is reduced")
    max_texture: int | None = Field(default=None, ge=16, description="pixels a side above which textures are reduced")
    retopo: int | None = Field(default=None, ge=64, le=200_000, description="triangles of a light mesh; None: as it is")
    recover_appearance: bool = Field(default=False, description="plausible materials where the source states none")
    generator: AppearanceGenerator | None = Field(
        default=None, description="a model of the user that proposes materials"
    )
    max_objects: int = Field(default=24, description="separate objects in one file above which a person decides")
    decisions: tuple[Decision, ...] = Field(default=(), description="of people about this very source, oldest first")
    outdated: tuple[Decision, ...] = Field(default=(), description="about its earlier content; told, never used")

    @property
    def calls_a_model(self) -> bool:
        """Whether a program or address of the user's is called, which may need the network."""
        return any(model is not None for model in (self.endpoint, self.segmenter, self.generator))

    def of_object(self, number: int) -> Options:
        """The options of one object of the source, or of the whole file with number 0: a person's decision about it
        replaces the options of the batch, and a later decision an earlier one.
        """
        about = tuple(d for d in self.decisions if d.object in (0, number))
        decided = {field: value for d in about for field, value in d.set.items()}
        nothing = {"units": "auto", "up_axis": "auto"}
        stated = {field: value or nothing.get(field) for field, value in decided.items()}
        return self.model_copy(update={**stated, "decisions": about, "outdated": ()})

    def provenance(self) -> dict[str, str]:
        """License and author as the user states them, each with `<field>_from`, its origin; {} where none is stated."""
        stated = {"license": self.license, "author": self.author}
        return {
            k: v
            for field, value in stated.items()
            if value
            for k, v in ((field, value), (f"{field}_from", self.origin(field)))
        }

    def origin(self, field: str) -> str:
        """Who states `field`: a person who decided, else the command line with its flag."""
        deciders = (f"decision by {d.by}" for d in reversed(self.decisions) if field in d.set)
        return next(deciders, f"--{field.replace('_', '-')}")

"""Base class and numbers of everything that an author writes in a scene program: frozen, unknown keys are errors."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Length = Annotated[float, Field(gt=0.0)]
Distance = Annotated[float, Field(ge=0.0)]
Range = tuple[float, float]


class Written(BaseModel):
    """One construct of the scene language."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

"""Input of the child process that draws an articulated object at joint positions."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.model import Model


@dataclass(frozen=True)
class JointsRequest:
    """An articulated object to draw at joint positions: save and draw it as a `RenderRequest`, with
    `python -m render.joints_worker`.

    model      canonical, with its mechanism.
    positions  of joints by name (rad, m), one picture each: `000.png` and so on in `out_dir`; other joints are at rest
               or follow.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    model: Model
    positions: tuple[dict[str, float], ...]
    out_dir: str
    size_px: int = 512

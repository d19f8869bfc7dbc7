"""Materials that a generative model of the user proposes for degraded surfaces; an answer is checked as hostile input.

A program gets two paths, of a question to read and an answer to write; a server gets the question by POST and sends the
answer. Both are JSON, in the form of `question_of` and `_Answer`; docs/explanation/appearance-recovery.md states it.
What it proposes is drawn and ranked beside the library, and is never surer than the family of the surface.
"""

from __future__ import annotations

import base64
import json
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from assetkit.annotate.exchange import Post, exchange_in_cell
from assetkit.annotate.prompt import cleaned
from assetkit.materials.recovery.library import METALS, LibraryMaterial
from assetkit.materials.recovery.surfaces import OpenSurface
from assetkit.options import AppearanceGenerator
from assetkit.taxonomy.category_materials import class_names
from jobs.cell import Limits, run_cell
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.outcome import EndpointUse

VERSION: Final = 1  # of the form of question and answer
MOST_PROPOSAL_BYTES: Final = 2**20  # an answer is some hundred bytes a surface
MOST_MATERIALS: Final = 64
MOST_OF_SURFACE: Final = 2  # proposals that are drawn; the library has four
MEMORY_MB: Final = 65536  # generative models map large files
_MOST_QUOTED: Final = 200
# Bounds of plausible surfaces: toothpaste, the brightest of paints, has 0.94; the darkest of metals, silicon, has 0.35
# (physicallybased.info).
_BRIGHTEST_PAINT, _DARKEST_METAL = 0.96, 0.2
_LEAST_METALLIC, _CLEAR_TRANSMISSION = 0.5, 0.3  # from which a material counts as bare metal, as see-through
_Share = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Proposal(_Strict):
    surface: int = Field(ge=0)
    name: str = Field(max_length=80)
    material_class: str = Field(max_length=40)
    base_color: list[_Share] = Field(min_length=3, max_length=3)
    roughness: _Share
    metallic: _Share
    ior: float = Field(default=1.5, ge=1.0, le=2.5, allow_inf_nan=False)
    transmission: _Share = 0.0


class _Answer(_Strict):
    materials: list[_Proposal] = Field(max_length=MOST_MATERIALS)


@dataclass(frozen=True)
class Proposals:
    """Materials per surface, in the order of the answer; `findings` on what could not be used."""

    of_surface: tuple[tuple[LibraryMaterial, ...], ...]
    findings: tuple[Diagnostic, ...] = ()
    use: EndpointUse | None = None


def question_of(
    surfaces: Sequence[OpenSurface], category: Evidence[str], file_name: str, views: Mapping[str, bytes]
) -> dict[str, Any]:
    """The question as JSON: the object, its degraded surfaces by number, and PNG pictures by name in base64."""
    return {
        "version": VERSION,
        "file": file_name,
        "category": category.value if category.confidence > 0.0 else None,
        "material_classes": list(class_names()),
        "surfaces": [
            {
                "surface": number,
                "label": surface.clues.label,
                "names": list(surface.clues.own_names),
                "reason": surface.degraded.reason.value,
                "open": list(surface.degraded.fields),
            }
            for number, surface in enumerate(surfaces)
        ],
        "views": {name: base64.b64encode(picture).decode() for name, picture in views.items()},
    }


def proposals(generator: AppearanceGenerator, question: Mapping[str, Any], count: int, work_dir: Path) -> Proposals:
    """The plausible materials that the generator proposes for `count` surfaces; never raises for what it does."""
    name = name_of(generator)
    text, problem, use = (_by_post if generator.url else _by_command)(generator, question, work_dir)
    nothing = tuple(() for _ in range(count))
    if problem:
        return Proposals(nothing, (_failed(name, problem),), use)
    try:
        answer = _Answer.model_validate_json(text)
    except (ValidationError, ValueError, RecursionError):
        return Proposals(nothing, (_failed(name, "its answer is missing, too large or of another form"),), use)
    taken: list[list[LibraryMaterial]] = [[] for _ in range(count)]
    refused: list[str] = []
    for proposal in answer.materials:
        why = implausible(proposal, count)
        if not why and len(taken[proposal.surface]) >= MOST_OF_SURFACE:
            why = f"more than {MOST_OF_SURFACE} materials for surface {proposal.surface}"
        if why:
            refused.append(why)
        else:
            taken[proposal.surface].append(_entry(proposal, name, len(taken[proposal.surface])))
    findings = (_failed(name, f"left out: {'; '.join(dict.fromkeys(refused))}"[:_MOST_QUOTED]),) if refused else ()
    return Proposals(tuple(tuple(each) for each in taken), findings, use)


def implausible(proposal: _Proposal, count: int) -> str:
    """Why a proposal is left out; "" when it may be drawn."""
    if proposal.surface >= count:
        return f"there is no surface {proposal.surface}"
    if proposal.material_class not in class_names():
        return "an unknown class of material"
    metal = proposal.material_class in METALS
    if metal != (proposal.metallic > _LEAST_METALLIC):
        return f"{proposal.material_class} of metallic {proposal.metallic:g}"
    if metal and max(proposal.base_color) < _DARKEST_METAL:
        return f"a metal darker than {_DARKEST_METAL:g}"
    if not metal and proposal.transmission < _CLEAR_TRANSMISSION and min(proposal.base_color) > _BRIGHTEST_PAINT:
        return f"a paint brighter than {_BRIGHTEST_PAINT:g}"
    return ""


def name_of(generator: AppearanceGenerator) -> str:
    """The generator's name in evidence: of a program its last word that is a file, else its first; no folders."""
    if generator.url:
        return generator.url
    files = [word for word in generator.command if Path(word).is_file()]
    return Path(files[-1] if files else generator.command[0]).name


def _by_command(
    generator: AppearanceGenerator, question: Mapping[str, Any], work_dir: Path
) -> tuple[str, str, EndpointUse | None]:
    """The text of the answer and why there is none."""
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        question_file, answer_file = Path(place, "question.json"), Path(place, "answer.json")
        question_file.write_text(json.dumps(question), encoding="utf-8")
        command = [*generator.command, str(question_file), str(answer_file)]
        result = run_cell(command, Limits(generator.seconds, MEMORY_MB))
        if result.status != "ok":
            last = (result.output.strip().splitlines() or ["no output"])[-1]
            return "", f"{result.status.replace('_', ' ')}: {cleaned(last, _MOST_QUOTED)}", None
        try:
            plain = answer_file.is_file() and not answer_file.is_symlink()
            if not plain or answer_file.stat().st_size > MOST_PROPOSAL_BYTES:
                return "", "its answer is missing, too large or no plain file", None
            return answer_file.read_bytes().decode(errors="replace"), "", None
        except OSError:
            return "", "its answer cannot be read", None


def _by_post(
    generator: AppearanceGenerator, question: Mapping[str, Any], work_dir: Path
) -> tuple[str, str, EndpointUse | None]:
    """The same from a server, which gets no key."""
    reply = exchange_in_cell(Post(url=generator.url, body=dict(question), seconds=generator.seconds), work_dir)
    return reply.text, reply.failure, EndpointUse(requests=reply.attempts)


def _entry(proposal: _Proposal, generator: str, number: int) -> LibraryMaterial:
    red, green, blue = proposal.base_color
    word = re.sub(r"[^a-z0-9]+", "_", proposal.name.lower()).strip("_")[:40] or "material"
    return LibraryMaterial(
        name=f"generated_{word}" if number == 0 else f"generated_{word}_{number + 1}",
        material_class=proposal.material_class,
        red=red,
        green=green,
        blue=blue,
        roughness=proposal.roughness,
        metallic=proposal.metallic,
        ior=proposal.ior,
        transmission=proposal.transmission,
        usual=1.0,
        colour_basis="generated",
        source=f"proposed by {generator}",
        licence="as of the generator",
    )


def _failed(name: str, why: str) -> Diagnostic:
    return finding("asset/appearance-generator-failed", f"'{name}': {why}")

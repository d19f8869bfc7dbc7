"""`mana schema`: the JSON Schema of what Mana reads and writes, for editors and other tools."""

from __future__ import annotations

import json
from typing import Annotated

import typer
from pydantic import BaseModel

from assetkit.generate.truth import GeneratedTruth
from scenec.source.language import editor_schema
from schemas.asset import AssetRecord
from schemas.measurement import MeasurementSpec
from schemas.replay.episode import EpisodeDescription
from schemas.report import IngestReport
from schemas.scene.runtime_plan import RuntimePlan
from schemas.scene.samples import SceneSamples

app = typer.Typer(help="Print the JSON Schema of a file Mana reads or writes.", no_args_is_help=True)
_MODELS: dict[str, type[BaseModel]] = {
    "asset": AssetRecord,
    "episode": EpisodeDescription,
    "measurement": MeasurementSpec,
    "plan": RuntimePlan,
    "report": IngestReport,
    "samples": SceneSamples,
    "truth": GeneratedTruth,
}


def _print(name: str) -> None:
    print(json.dumps(_MODELS[name].model_json_schema(), indent=1, sort_keys=True))


@app.command("asset")
def asset(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of `record.json`.

    Example: `mana schema asset > record.schema.json`
    """
    _print("asset")


@app.command("episode")
def episode(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of `episode.json`, the description of a recorded episode.

    Example: `mana schema episode > episode.schema.json`
    """
    _print("episode")


@app.command("measurement")
def measurement(
    as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True,
) -> None:
    """The schema of `measurement.yaml`.

    Example: `mana schema measurement > measurement.schema.json`
    """
    _print("measurement")


@app.command("plan")
def plan(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of `plan.json`.

    Example: `mana schema plan > plan.schema.json`
    """
    _print("plan")


@app.command("samples")
def samples(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of what `mana plan sample` writes.

    Example: `mana schema samples > samples.schema.json`
    """
    _print("samples")


@app.command("report")
def report(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of `report.json`.

    Example: `mana schema report > report.schema.json`
    """
    _print("report")


@app.command("truth")
def truth(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of `truth.json`, which `mana assets generate` writes beside its sources.

    Example: `mana schema truth > truth.schema.json`
    """
    _print("truth")


@app.command("scene")
def scene(as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True) -> None:
    """The schema of scene programs, the same as `mana scene schema`.

    Example: `mana schema scene > scene.schema.json`
    """
    print(json.dumps(editor_schema(), indent=1, sort_keys=True))

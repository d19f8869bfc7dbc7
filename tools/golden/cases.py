"""The fixed set: which commands run, on which inputs, in which groups.

A case is a list of steps; each step is one command line. Its output files lie in the case's folder, which is compared.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.golden import inputs

GROUPS = ("assets", "scenes", "replay", "gap", "docs", "schemas")
PACKAGES = "assets/packages"  # the library that scenes and episodes take objects from
SCHEMAS = ("asset", "episode", "measurement", "plan", "samples", "report", "scene")
SCENES = (
    "crate_contents",
    "crowded_sink",
    "grid_rows_columns",
    "mixed_variants",
    "ood_split",
    "rack_slots",
    "robot_reach",
    "scatter_40",
    "shelf_rows",
    "stacked_bin",
    "stacked_plates",
    "table_setting",
    "three_cycle",
    "tray_of_mugs",
)

_OWN = ("objects/mug.obj", "tray/tray_textured.obj", "duck.obj", "domino/domino.obj")  # of pybullet_data
_MORE = ("torus/torus_textured.obj", "stone.obj", "kuka_iiwa/meshes/finger_tip_left.stl", "racecar/meshes/cone.dae")
_SHARED_MESHES = (
    "glb/khr_duck_glb/Duck.glb",
    "glb/sapien_water_bottle_glb/water_bottle.glb",
    "glb/habitat_chair_glb/chair.glb",
    "glb/gt_boxmeshopt_glb/BoxMeshopt.glb",
    "glb/genesis_camera_glb/camera.glb",
    "gltf/khr_duck_specgloss/Duck.gltf",
    "gltf/gt_boxdraco/BoxDraco.gltf",
    "gltf/drake_bin/bin.gltf",
    "dae/khr_duck_dae/Duck.dae",
    "dae/as_cube_utf8bom_dae/cube_UTF8BOM.dae",
    "usd/uwg_teapot/Teapot.usd",
    "usd/tus_suzanne_usdc/suzanne.usdc",
    "usd/tus_texturedcube_usda/texturedcube.usda",
    "usd/uwg_chess_king/King.usd",
    "usdz/uwg_roughness_usdz/RoughnessTest.usdz",
    "stl/tm_featuretype_stl/featuretype.STL",
    "ply/tm_reference_ply/reference.ply",
    "obj/tm_fuze_obj/fuze.obj",
    "obj/as_spider_obj/spider.obj",
)
_SHARED_BROKEN = (
    "malformed/glb/gen_truncated_glb/part.glb",
    "malformed/glb/gen_accessor_overrun/part.glb",
    "malformed/glb/gen_corrupt_texture/part.glb",
    "malformed/glb/gen_mirror_node_glb/hook.glb",
    "malformed/glb/gen_open_cup_solid/part.glb",
    "malformed/obj/gen_overlapping_bodies/part.obj",
    "malformed/obj/gen_open_sheet_box/part.obj",
    "malformed/obj/gen_nonmanifold_fin/part.obj",
    "malformed/ply/gen_mixed_winding/part.ply",
    "malformed/stl/gen_units_mug_mm/coffee_mug.stl",
    "malformed/stl/gen_many_components/part.stl",
    "malformed/usd/gen_usd_self_reference/part.usda",
    "malformed/usdz/gen_usdz_zip_slip/part.usdz",
    "blend/as_suzanne_248_blend/BLEND/Suzanne_248.blend",
    "glb/lfs_pointer_sheenchair_glb/SheenChair.glb",
    "urdf/habitat_fridge_urdf/fridge.urdf",
)


@dataclass(frozen=True)
class Place:
    """Folders of a case: `out` is compared, `made` is for inputs; `library` holds packages, `bullet` pybullet's data.

    `shared` is None where the shared data are absent.
    """

    repo: Path
    out: Path
    made: Path
    library: Path
    bullet: Path
    shared: Path | None

    @property
    def data(self) -> Path:
        """The shared data, for cases that run only where they are."""
        if self.shared is None:
            raise ValueError("this case needs the shared data")
        return self.shared


@dataclass(frozen=True)
class Step:
    """One command: `mana ARGS`, or `python -m MODULE ARGS`. What it prints is kept under `name`."""

    name: str
    args: tuple[str, ...]
    module: str = "cli.main"


@dataclass(frozen=True)
class Case:
    """Steps in their order; `name` is GROUP/NAME. `after` is a case whose outputs the steps read."""

    name: str
    steps: Callable[[Place], Sequence[Step]]
    shared: bool = False
    after: str | None = None

    @property
    def group(self) -> str:
        """One of GROUPS."""
        return self.name.split("/")[0]


def step(name: str, words: str, *more: object) -> Step:
    """A command of `words`, divided by spaces, and `more` arguments."""
    return Step(name, (*words.split(), *map(str, more)))


def all_cases() -> list[Case]:
    """Every case; long ones first, because two run at a time."""
    return [
        Case(PACKAGES, _packages),
        *_gap_cases(),
        Case("assets/shared_meshes", _ingest_shared(_SHARED_MESHES), shared=True),
        *(Case(f"scenes/{name}", _scene(name), after=PACKAGES) for name in SCENES),
        Case("scenes/broken", _broken_scene, after=PACKAGES),
        Case("assets/formats", _formats),
        Case("assets/shared_broken", _ingest_shared(_SHARED_BROKEN), shared=True),
        Case("replay/arm", _arm, after=PACKAGES),
        Case("replay/panda_lift", _panda_lift, shared=True, after=PACKAGES),
        Case("assets/broken", _broken_meshes),
        Case("assets/options", _options),
        Case("assets/decision", _decision),
        Case("assets/reading", _reading, after=PACKAGES),
        Case("docs/pages", _pages),
        Case("schemas/all", lambda _: [step(kind, f"schema {kind}") for kind in SCHEMAS]),
    ]


def _ingest(place: Place, name: str, sources: Sequence[Path], *more: object, root: Path | None = None) -> Step:
    bound = () if root is None else ("--root", root)
    return step(name, "assets ingest", *sources, *bound, *more, "--out", place.out / "library", "--jobs", 1, "--json")


def _packages(place: Place) -> list[Step]:
    return [_ingest(place, "ingest", [place.bullet / file for file in _OWN], root=place.bullet)]


def _formats(place: Place) -> list[Step]:
    inputs.meshes(place.made)
    return [
        _ingest(place, "own", [place.made]),
        _ingest(place, "installed", [place.bullet / file for file in _MORE], root=place.bullet),
    ]


def _broken_meshes(place: Place) -> list[Step]:
    inputs.broken_meshes(place.made)
    return [_ingest(place, "ingest", sorted(place.made.iterdir()))]


def _options(place: Place) -> list[Step]:
    words = "--units mm --up-axis y --role tool --category hammer --license CC-BY-4.0 --author Somebody"
    source = place.made / "rod.stl"
    inputs.rod_in_millimetres(source)
    return [_ingest(place, "ingest", [source], *words.split(), "--shell-thickness", 2, "--require-category")]


def _decision(place: Place) -> list[Step]:
    library = place.out / "library"
    inputs.meshes(place.made)
    decide = ("two_parts.glb", "--set", "category=mug", "--by", "golden", "--reason", "a test", "--json")
    return [
        _ingest(place, "before", [place.made / "two_parts.glb"]),
        step("review", "assets review", library, "--doubtful", "--json"),
        step("decide", "assets review", library, *decide),
        _ingest(place, "after", [place.made / "two_parts.glb"]),
    ]


def _reading(place: Place) -> list[Step]:
    domino = place.library / "domino"
    return [
        step("list", "assets list", place.library, "--json"),
        step("list_text", "assets list", place.library),
        step("show", "assets show", place.library / "mug", "--json"),
        step("show_text", "assets show", place.library / "mug"),
        step("search", "assets search cup --json --in", place.library),
        step("search_text", "assets search --max-size 30cm --in", place.library),
        step("validate", "assets validate --json", domino),
        step("render", "assets render --json", domino, "--out", place.out / "pictures"),
    ]


def _ingest_shared(files: Sequence[str]) -> Callable[[Place], list[Step]]:
    def steps(place: Place) -> list[Step]:
        root = place.data / "assets"
        return [_ingest(place, "ingest", [root / file for file in files], root=root)]

    return steps


def _scene(name: str) -> Callable[[Place], list[Step]]:
    def steps(place: Place) -> list[Step]:
        programs = shutil.copytree(place.repo / "examples" / "scenes", place.made / "scenes")  # some include others
        program = programs / f"{name}.yaml"
        compiled = place.out / "compiled"
        plan = compiled / "plan.json"
        found = step("compile", "scene compile", program, "--assets", place.library, "--out", compiled, "--json")
        steps = [found, *_diagnosed(place, program)]
        if name == "three_cycle":  # has no plan
            return steps
        return [
            *steps,
            step("sample", "plan sample --n 200 --seed 7 --out", place.out / "samples.json", plan),
            step("verify", "plan verify --n 2000 --json", plan),
            step("inspect", "plan inspect", plan, "--out", place.out / "inspect.png"),
            step("realise", "plan realise --n 2 --seed 7 --json", plan),
        ]

    return steps


def _broken_scene(place: Place) -> list[Step]:
    program = place.made / "broken.yaml"
    inputs.broken_scene(program)
    text = step("compile", "scene compile", program, "--assets", place.library, "--out", place.out / "compiled")
    return [text, *_diagnosed(place, program)]


def _diagnosed(place: Place, program: Path) -> Iterator[Step]:
    where = ("--assets", place.library, "--out", place.out / "diagnosed")
    yield step("diagnose", "scene diagnose", program, *where, "--json")
    yield step("diagnose_text", "scene diagnose", program, *where)


def _arm(place: Place) -> list[Step]:
    arm = place.bullet / "franka_panda"
    (place.made / "arm").mkdir()
    inputs.episode(place.made / "arm", arm)
    variant = place.out / "variants" / "arm" / "variant_0000"
    where = ("--meshes", arm)
    pictures = ("--out", place.out / "pictures", "--every", 80, "--json")
    return [
        *_augmented(place, place.made / "arm", *where),
        step("compose", "replay compose", variant, "--assets", place.out / "variants" / "packages", *where),
        step("render", "replay render", variant, "--assets", place.out / "variants" / "packages", *where, *pictures),
        step("envelope", "replay envelope --json", place.made / "arm", "--out", place.out / "envelope", *where),
    ]


def _panda_lift(place: Place) -> list[Step]:
    return _augmented(place, place.data / "episodes" / "panda_lift")


def _augmented(place: Place, episode: Path, *more: object) -> list[Step]:
    out = place.out / "variants"
    draw = "replay augment --variants 3 --objects 2 --seed 5 --json"
    return [
        step("augment", draw, episode, "--assets", place.library, "--out", out, *more),
        step("verify", "replay verify --json", out, *more),
    ]


def _gap_cases() -> list[Case]:
    return [
        Case("gap/pendulum", _converted("pendulum", "single"), shared=True),
        Case("gap/foreign_mechanism", _foreign("case_0001"), shared=True),
        Case("gap/foreign_free_body", _foreign("case_0055"), shared=True),
        Case("gap/planar_push", _converted("planar_push", "abs_three_10_90"), shared=True),
        Case("gap/ellipse_impact", _converted("ellipse_impact"), shared=True),
        *(Case(f"gap/{kind}", _generated(kind)) for kind in inputs.MEASUREMENTS),
        Case("gap/extend", _extended, after=PACKAGES),
        Case("gap/effects", lambda _: [step("all", "gap effects"), step("one", "gap effects joint.backlash")]),
    ]


def _found(place: Place, measurement: Path) -> list[Step]:
    found = place.out / "found"
    extension = ("--extension", found / "extension.json")
    return [
        step("find", "gap find --quick --json", measurement, "--out", found),
        step("simulate", "gap simulate --json", measurement, *extension, "--out", place.out / "simulated"),
    ]


def _generated(kind: str) -> Callable[[Place], list[Step]]:
    def steps(place: Place) -> list[Step]:
        inputs.MEASUREMENTS[kind](place.made)
        return _found(place, place.made)

    return steps


def _extended(place: Place) -> list[Step]:
    inputs.impact(place.made)
    extension = place.out / "found" / "extension.json"
    return [
        step("find", "gap find --json", place.made, "--out", place.out / "found"),
        step("extend", "gap extend --json", place.library / "domino", extension, "--out", place.out / "extended"),
    ]


def _converted(name: str, part: str = "") -> Callable[[Place], list[Step]]:
    def steps(place: Place) -> list[Step]:
        source = str(place.data / "measured" / name)
        target = place.made / "measurement"
        args = (source, str(target), part) if part else (source, str(target))
        return [Step("convert", args, f"examples.measured.{name}"), *_found(place, target)]

    return steps


def _foreign(case: str) -> Callable[[Place], list[Step]]:
    return lambda place: _found(place, place.data / "measured" / "foreign" / case)


def _pages(place: Place) -> list[Step]:
    """Copies, no command: the pages as they are in the tree."""
    docs = place.repo / "docs"
    shutil.copytree(docs / "diagnostics", place.out / "diagnostics")
    (place.out / "reference").mkdir()
    for name in ("gate.md", "effects.md"):
        shutil.copy(docs / "reference" / name, place.out / "reference")
    return []

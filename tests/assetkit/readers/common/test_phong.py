"""Phong materials of MTL and COLLADA: bare metals are recognised, paints are left alone, and origins are told apart."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given

from assetkit.readers.common.phong import bare_metal, linear_rgb
from schemas.appearance.material import Anisotropy, Material, Sheen
from tests.assetkit.readers.collada.test_read import dae
from tests.assetkit.readers.collada.test_read import model as model_of_dae
from tests.assetkit.readers.obj.test_read import model, read

TRIANGLE = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"
GOLD = (1.0, 0.89, 0.62)
colors = st.tuples(*[st.floats(0.0, 1.0)] * 3)


def of_mtl(folder: Path, statements: str) -> Material:
    (material,) = model(read(folder, TRIANGLE, **{"m.mtl": f"newmtl m\n{statements}\n"})).materials
    return material


def of_dae(folder: Path, phong: str) -> Material:
    (material,) = model_of_dae(folder, dae(effect=f"<phong>{phong}</phong>")).materials
    return material


def element(tag: str, *numbers: float) -> str:
    kind = "float" if len(numbers) == 1 else "color"
    return f"<{tag}><{kind}>{' '.join(map(str, numbers))}</{kind}></{tag}>"


@given(colors, colors)
def test_a_surface_is_metal_only_where_it_is_black_and_mirrors(diffuse, specular):
    metal = bare_metal(diffuse, specular)
    black, bright = max(linear_rgb(diffuse)) <= 0.03, max(linear_rgb(specular)) >= 0.25
    assert metal == (linear_rgb(specular) if black and bright else None)


def test_gold_of_both_formats_is_gold(tmp_path: Path):
    shown = " ".join(map(str, GOLD))
    (tmp_path / "obj").mkdir()
    (tmp_path / "dae").mkdir()
    obj = of_mtl(tmp_path / "obj", f"Kd 0 0 0\nKs {shown}\nNs 200")
    dae = of_dae(
        tmp_path / "dae", element("diffuse", 0, 0, 0, 1) + element("specular", *GOLD, 1) + element("shininess", 200)
    )
    for gold in (obj, dae):
        assert gold.base_color == pytest.approx(linear_rgb(GOLD))
        assert gold.metallic == 1.0
        assert (gold.origins["metallic"].source, gold.origins["base_color"].source) == ("inferred", "inferred")
        assert gold.origins["metallic"].confidence < 1.0
    assert obj.roughness == pytest.approx(dae.roughness)


@pytest.mark.parametrize(
    "statements", ["Kd 0.5 0.1 0.1\nKs 0.5 0.5 0.5", "Kd 0 0 0\nKs 0 0 0", "Kd 0 0 0\nKs 1 1 1\nPm 0", "Kd 0 0 0"]
)
def test_paints_stay_paints(statements: str, tmp_path: Path):
    assert of_mtl(tmp_path, statements).metallic == 0.0


def test_sheen_and_anisotropy_of_mtl_have_fields(tmp_path: Path):
    got = of_mtl(tmp_path, "Kd 1 1 1\nPs 0.25\naniso 0.5\nanisor 0.25")
    assert got.sheen == Sheen((0.25, 0.25, 0.25))
    assert got.anisotropy == Anisotropy(0.5, math.tau / 4)
    assert got.unmapped == {}
    assert {got.origins[field].method for field in ("sheen.color", "anisotropy.strength")} == {"Ps", "aniso"}


@pytest.mark.parametrize(
    ("statements", "source", "method"),
    [
        ("Kd 1 1 1\nPr 0.3", "declared", "Pr"),
        ("Kd 1 1 1\nNs 50", "inferred", "Ns: "),
        ("Kd 1 1 1\nKs 0 0 0", "inferred", "a surface without a highlight"),
    ],
)
def test_the_origin_of_roughness_tells_statement_from_conversion(
    statements: str, source: str, method: str, tmp_path: Path
):
    origin = of_mtl(tmp_path, statements).origins["roughness"]
    assert origin.source == source
    assert origin.method.startswith(method)
    assert (origin.confidence == 1.0) == (source == "declared")


@pytest.mark.parametrize(
    "statements",
    ["Kd 0.2 0.3 0.4\nKe 1 0 0\nd 0.5\nNi 1.3\nPc 0.5\nPcr 0.1\nPm 0.7\nPr 0.2\nPs 1", "Kd 1 1 1\nNs 10\nTr 0.4"],
)
def test_whatever_differs_from_the_default_has_an_origin(statements: str, tmp_path: Path):
    got = of_mtl(tmp_path, statements)
    default = Material(got.name)
    differing = {f.name for f in fields(Material) if getattr(got, f.name) != getattr(default, f.name)}
    assert differing - {"origins", "unmapped", "normal_green"} <= {field.partition(".")[0] for field in got.origins}


def test_an_absent_picture_is_behind_no_value(tmp_path: Path):
    got = of_mtl(tmp_path, "Kd 0.2 0.3 0.4\nmap_Kd absent.png\nmap_Pr absent.png\nPr 0.25")
    assert (got.base_color_texture, got.roughness_texture) == (None, None)
    assert (got.origins["base_color"].method, got.origins["roughness"].method) == ("Kd", "Pr")

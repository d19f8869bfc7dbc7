"""Source names of prims: kept where they are identifiers, reported where they had to change."""

from __future__ import annotations

from dataclasses import replace

from tests.support import package_samples as samples
from usdio.write.source_names import rename_findings, source_names


def test_changed_names_are_said_and_kept() -> None:
    plain = source_names(samples.model([samples.box_mesh(name="body")]))
    assert plain == {"Visuals/body": "body", "Materials/neutral": "neutral"}
    assert rename_findings(plain) == ()
    awkward = source_names(samples.model([samples.box_mesh(name=name) for name in ("a b", "a b", "ok")]))
    assert awkward["Visuals/a_b_2"] == "a b"
    (diagnostic,) = rename_findings(awkward)
    assert (diagnostic.code, diagnostic.value, diagnostic.severity) == ("asset/name-sanitised", 2, "info")


def test_a_prim_is_called_by_the_id_of_its_mesh() -> None:
    model = samples.model([samples.box_mesh(name="cup")])
    renamed = replace(model, meshes=(replace(model.meshes[0], id="vessel"),))
    assert source_names(renamed)["Visuals/vessel"] == "cup"

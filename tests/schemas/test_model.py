"""Ids of meshes: one each, made once from the names, and kept whatever happens to the names or to other meshes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.support import package_samples as samples


def test_ids_are_identifiers_of_their_own() -> None:
    model = samples.model([samples.box_mesh(name=name) for name in ("cup", "cup", "Cup", "größe", "机器")])
    assert list(model.meshes_by_id) == ["cup", "cup_2", "Cup_3", "gro_e", "mesh"]


def test_an_id_stays_when_another_mesh_goes_or_a_name_changes() -> None:
    model = samples.model([samples.box_mesh(name="cup"), samples.box_mesh(name="cup")])
    rest = replace(model, meshes=(replace(model.meshes[1], name="lid"),))
    assert list(rest.meshes_by_id) == ["cup_2"]


def test_meshes_without_ids_of_their_own_are_refused() -> None:
    model = samples.model([samples.box_mesh(), samples.box_mesh()])
    for ids in (("", "a"), ("a", "a")):
        meshes = tuple(replace(mesh, id=i) for mesh, i in zip(model.meshes, ids, strict=True))
        with pytest.raises(ValueError, match="ids of their own"):
            _ = replace(model, meshes=meshes).meshes_by_id

"""URDF files as a whole: places, materials, contacts; ten thousand links; damaged files never crash the reader."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import numpy as np
import pybullet_data
import pytest
from hypothesis import given
from hypothesis import strategies as st

from formats import link_poses, read_urdf
from schemas.diagnostics import InvalidInput
from tests.support.bad_inputs.robot import AB, joint, link, urdf, write

R2D2 = Path(pybullet_data.getDataPath()) / "r2d2.urdf"
LINKS = 10_000
MOST_CPU_S = 10.0  # ten thousand links take about 1 s; quadratic time would be minutes


def test_every_element_keeps_its_line(tmp_path: Path) -> None:
    path = write(urdf(AB, joint("j", "a", "b"), link("c"), joint("k", "b", "c", "fixed")), tmp_path)
    description = read_urdf(path)
    assert [(e.name, e.source.line) for e in (*description.links, *description.joints)] == [
        ("a", 2), ("b", 3), ("c", 5), ("j", 4), ("k", 6),
    ]  # fmt: skip
    assert {e.source.file for e in description.links} == {"model.urdf"}


def test_materials_are_found_by_name_in_a_real_file() -> None:
    description = read_urdf(R2D2)
    colors = {s.material.name: s.material.rgba for link in description.links for s in link.shapes if s.material}
    assert colors["blue"] == (0.0, 0.0, 0.8, 1.0)
    assert colors["white"] == (1.0, 1.0, 1.0, 1.0)


def test_contacts_of_bullet_and_drake_are_read(tmp_path: Path) -> None:
    drake = '<drake:proximity_properties><drake:mu_static value="0.7"/><drake:mu_dynamic value="0.5"/>'
    ball = f'<collision><geometry><sphere radius="1"/></geometry>{drake}</drake:proximity_properties></collision>'
    contact = '<contact><lateral_friction value="0.9"/><friction_anchor/><rolling_friction value="0.1"/></contact>'
    description = read_urdf(write(urdf(link("a", contact + ball)), tmp_path))
    (only,) = description.links
    assert list(only.contact.items()) == [("lateral_friction", 0.9), ("rolling_friction", 0.1)]
    assert only.shapes[0].friction == (0.7, 0.5)
    assert [e.tag for e in description.unread] == ["friction_anchor"]


@pytest.mark.parametrize("shape", ["chain", "star"])
def test_ten_thousand_links_take_linear_time(shape: str, tmp_path: Path) -> None:
    parents = [k - 1 if shape == "chain" else 0 for k in range(1, LINKS)]
    offset = '<origin xyz="0.001 0 0"/>'
    mimic = [f'<mimic joint="j{k - 1}"/>' if k > 1 else "" for k in range(1, LINKS)]
    joints = [joint(f"j{k}", f"l{p}", f"l{k}", inside=offset + mimic[k - 1]) for k, p in enumerate(parents, 1)]
    path = write(urdf(*(link(f"l{k}") for k in range(LINKS)), *reversed(joints)), tmp_path)
    began_s = time.process_time()
    description = read_urdf(path)
    assert len(description.links) == LINKS
    assert time.process_time() - began_s < MOST_CPU_S
    X_RL = link_poses(description, {f"j{k}": 0.0 for k in range(1, LINKS)})
    np.testing.assert_allclose(X_RL[f"l{LINKS - 1}"][0, 3], 0.001 * (LINKS - 1 if shape == "chain" else 1))
    assert time.process_time() - began_s < MOST_CPU_S


SMALL = urdf(
    link("a", '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'),
    link("b", '<collision><geometry><box size="1 1 1"/></geometry></collision>'),
    joint("j", "a", "b", "revolute", '<axis xyz="0 0 1"/><limit lower="-1" upper="1"/><dynamics damping="1"/>'),
)["model.urdf"].encode()


@given(st.lists(st.tuples(st.integers(0, len(SMALL) - 1), st.binary(max_size=6)), min_size=1, max_size=4))
def test_damaged_files_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, damage: list[tuple[int, bytes]]
) -> None:
    data = SMALL
    for at, inserted in damage:
        data = data[:at] + inserted + data[at + 1 :]
    path = tmp_path_factory.mktemp("fuzz") / "model.urdf"
    path.write_bytes(data)
    with contextlib.suppress(InvalidInput):
        read_urdf(path)

"""+x of a released object is its front, however its source was turned; what has no front keeps its heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.options import Options
from assetkit.pipeline import STAGES, run_stages
from assetkit.pose.front import Front, turn_to_front
from assetkit.stage import Canonical, Draft, Intake, Interaction, Tools
from assetkit.stage_log import StageLog
from benchmarks.assets.made_things import things
from geom.features.mirror_symmetry import mirror_plane_heading
from geom.pose import matrix_of
from jobs.cache import Cache
from schemas.arrays import FloatArray
from schemas.evidence import declared, default, inferred, measured
from schemas.model import Mesh, Model
from sim.fake import FakeSimulator
from tests.support.present import present

MADE = {t.name: t for t in things(seed=3, draws=1)}


def about_z(yaw_rad: float) -> FloatArray:
    R = Rotation.from_euler("z", yaw_rad).as_matrix()
    return np.rint(R) if np.allclose(R, np.rint(R)) else R


def observed(folder: Path, name: str, yaw_rad: float) -> tuple[FloatArray, Draft]:
    """Points (n, 3) of a made thing as its source has them, and the draft after its interaction stage."""
    thing = MADE[name]
    points = thing.points @ about_z(yaw_rad).T
    x, y, z = (float(v) for v in np.ptp(points, axis=0))
    mesh = Mesh("m", points, thing.triangles, id="m")
    model = Model((mesh,), (), (), (), declared(1.0, "test"), declared("z", "test"))
    options = Options(units="m", up_axis="z", category=thing.category)
    draft = Draft("part", "part.obj", Intake("obj", (), model, (x, y, z)))
    tools, cache = Tools(FakeSimulator(), folder, options), Cache(folder / f"{yaw_rad:.4f}")
    done = run_stages(draft, tools, StageLog(), cache, "key", STAGES.up_to("interaction"))
    assert done is not None
    return points, done


def released(draft: Draft) -> FloatArray:
    """(n, 3) points in the asset frame."""
    return np.concatenate([m.points for m in draft[Canonical].meshes])


def test_a_turned_source_gives_the_same_object(tmp_path: Path) -> None:
    """The handle of a made mug sticks out towards +x of its source, so that exactly half a turn is due there."""
    points, straight = observed(tmp_path, "mug", 0.0)
    assert np.ptp(released(straight), axis=0) == pytest.approx(np.ptp(points, axis=0), abs=1e-12)
    points, turned = observed(tmp_path, "mug", np.radians(31.0))
    assert np.abs(released(turned) - released(straight)).max() < 1e-4
    front = present(turned[Interaction].front)
    assert front.direction.value == (1.0, 0.0, 0.0)
    assert front.direction.confidence > 0.5
    ends = [[(p.value.low_m, p.value.high_m) for p in d[Interaction].parts] for d in (straight, turned)]
    assert np.allclose(*ends, atol=1e-3)
    section = turned[Canonical].section
    back = (released(turned) - section.origin_offset_m) @ matrix_of(np.array(section.source_quat_wxyz))
    assert np.allclose(back, points, atol=1e-6)


def test_what_has_no_front_keeps_its_heading(tmp_path: Path) -> None:
    points, draft = observed(tmp_path, "tumbler called mug", 0.4)
    assert draft.frame is None
    assert present(draft[Interaction].front).direction.confidence == 0.0
    assert np.allclose(np.ptp(released(draft), axis=0), np.ptp(points, axis=0), atol=1e-9)


def test_quarter_turns_are_exact_and_the_front_stays_after_its_turn() -> None:
    told = inferred((0.0, -1.0, 0.0), "where it works", 0.8, inputs=("handle on the back",))
    turned = turn_to_front(Front(told, measured(1, "test")))
    assert turned is not None
    R, front = turned
    assert (R == [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).all()
    assert front.direction.inputs == told.inputs
    assert turn_to_front(front) is None
    assert turn_to_front(Front(default((0.0, 1.0, 0.0)), measured(1, "test"))) is None


@pytest.mark.parametrize("heading_rad", [0.0, 0.3, 2.0])
def test_the_mirror_plane_of_a_wedge_is_found(heading_rad: float) -> None:
    """Scaled and turned: it goes with the shape. A border of the window is no plane."""
    wedge = trimesh.creation.extrude_triangulation([[3.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]], [[0, 1, 2]], 1.0)
    points = 0.01 * wedge.vertices @ about_z(heading_rad).T
    centre = np.average(points[wedge.faces].mean(axis=1), axis=0, weights=wedge.area_faces)
    found = mirror_plane_heading(points, wedge.faces, centre, heading_rad + 0.2, 0.36)
    assert found is not None
    assert found[0] == pytest.approx(heading_rad, abs=2e-3)
    assert found[1] < 1e-4
    assert mirror_plane_heading(points, wedge.faces, centre, heading_rad + 0.45, 0.36) is None

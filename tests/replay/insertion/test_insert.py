"""Where things are put among supports on which nothing moves."""

import numpy as np
from shapely.geometry import Polygon, box

from replay.envelope.envelope import Envelope
from replay.insertion.candidates import InsertionCandidate
from replay.insertion.free_space import FreeSpace
from replay.insertion.insert import YAW_TRIES, InsertionSite, insert
from replay.insertion.supports import Support
from schemas.scene.geometry import Prism
from schemas.scene.runtime_plan import PlanBody, PlanStance

_NONE = np.zeros(0)
STILL = Envelope((), (), _NONE.astype(int), np.zeros((0, 3)), np.zeros((0, 3)), *[_NONE] * 6, clearance_m=0.01)
STANCE = PlanStance(
    name="upright",
    quat_wxyz=(1.0, 0.0, 0.0, 0.0),
    origin_height_m=0.0,
    prisms=(Prism(np.array([(-0.04, -0.04), (0.04, -0.04), (0.04, 0.04), (-0.04, 0.04)]), 0.0, 0.1),),
)
BOX = PlanBody(asset_id="box", stances=(STANCE,))


def site(name: str, area: Polygon) -> InsertionSite:
    return InsertionSite(FreeSpace(Support(name, name, 0.5, area), STILL, ()), Polygon(), frozenset({name}))


def test_what_has_no_room_at_one_place_of_a_plan_is_still_tried_at_another():
    places = [site("shelf", box(0.0, 0.0, 0.05, 0.05)), site("table", box(1.0, 0.0, 2.0, 1.0))]
    tried = [InsertionCandidate(BOX, STANCE, place="shelf")] * YAW_TRIES + [
        InsertionCandidate(BOX, STANCE, place="table")
    ]
    (put,) = insert(places, tried, 1, np.random.default_rng(0))
    assert put.stated.support == "table"
    assert box(1.0, 0.0, 2.0, 1.0).contains(put.outline)

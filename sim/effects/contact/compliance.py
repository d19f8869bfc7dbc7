"""Contact compliance: the contact yields as a spring (N/m) and a damper (N s/m)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import Bounds, TossCandidacy, Values
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TossRanges

_DEEPEST, _USUAL, _SHALLOWEST = 0.1, 1e-3, 1e-4  # of the size: how far the body sinks in under its weight
_HARDEST = 4e-6  # of the size: how far it sinks in where no spring is declared, less than an engine resolves
_MOST_DAMPED, _USUALLY_DAMPED = 4.0, 0.08  # times what brakes the swing on the usual spring critically, over two


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, stiffness_Npm=params["stiffness_Npm"], damping_Nspm=params["damping_Nspm"])


def _declared(r: TossRanges) -> Values:
    """Without a declared spring the contact is stiffer than shows at this weight and size."""
    if r.body.stiffness_Npm is None or r.body.damping_Nspm is None:
        return {
            "stiffness_Npm": r.weight_N / (_HARDEST * r.size_m),
            "damping_Nspm": _USUALLY_DAMPED * r.body.mass_kg * _slowest_radps(r),
        }
    return {"stiffness_Npm": r.body.stiffness_Npm, "damping_Nspm": r.body.damping_Nspm}


def _slowest_radps(r: TossRanges) -> float:
    """Swing on the usual spring."""
    return float(np.sqrt(r.gravity_mps2 / (_USUAL * r.size_m)))


def _bounds(r: TossRanges) -> Bounds:
    return {
        "stiffness_Npm": (r.weight_N / (_DEEPEST * r.size_m), r.weight_N / (_SHALLOWEST * r.size_m)),
        "damping_Nspm": (0.0, _MOST_DAMPED * r.body.mass_kg * _slowest_radps(r)),
    }


EFFECT = Effect(
    name="contact.compliance",
    kinds=("free_body",),
    formula="normal force = stiffness_Npm * depth + damping_Nspm * rate of depth",
    source="Kelvin and Voigt; Hunt and Crossley, J. Appl. Mech. 42, 1975, for spheres",
    reveals="contacts last several frames; the body sinks in",
    parameters=(
        Parameter("stiffness_Npm", "N/m", 10.0, 1e7, 1e7),
        Parameter("damping_Nspm", "N s/m", 0.0, 1e4, 10.0),
    ),
    confusables=(
        Confusable("contact.restitution", "drop from several heights"),
        Confusable("body.size", "rest without motion: size shifts the height, compliance little"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(observable=lambda r: r.body.has_support, null=_declared, bounds=_bounds),
    export=Export(
        usd="physxMaterial:compliantContactStiffness",
        urdf="contact/stiffness",
        urdf_contact={"stiffness_Npm": "stiffness", "damping_Nspm": "damping"},
    ),
)

"""Proofs that a problem has no scene. The docstring of each argument states its theorem; no proof is ever false, all
are deterministic, and None leaves open whether a scene exists.

    prove(problem)          cheap arguments first, then the complete one for few things
    prove_cheaply(problem)  takes milliseconds; the solver calls it before it searches
    refutation(problem)     the proof and its argument, which can be applied again to parts of the problem
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from scenec.proofs.refute import prove, prove_cheaply, refutation

__all__ = ["prove", "prove_cheaply", "refutation"]
__getattr__, __dir__ = lazy_exports(__name__, dict.fromkeys(__all__, "scenec.proofs.refute"))

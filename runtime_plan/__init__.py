"""Draw scenes from a compiled plan: thousands in a moment, each valid by construction."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from runtime_plan.plan import Plan, prepare
    from runtime_plan.read_plan import load
    from runtime_plan.restriction import Restriction, restrict
    from runtime_plan.sampler import sample
    from runtime_plan.samples import Samples
    from runtime_plan.samples_file import as_document, read_samples

__all__ = ["Plan", "Restriction", "Samples", "as_document", "load", "prepare", "read_samples", "restrict", "sample"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Plan": "runtime_plan.plan",
        "Restriction": "runtime_plan.restriction",
        "Samples": "runtime_plan.samples",
        "as_document": "runtime_plan.samples_file",
        "load": "runtime_plan.read_plan",
        "prepare": "runtime_plan.plan",
        "read_samples": "runtime_plan.samples_file",
        "restrict": "runtime_plan.restriction",
        "sample": "runtime_plan.sampler",
    },
)

"""Draw scenes from a compiled plan: thousands in a moment, each valid by construction."""

from runtime_plan.plan import Plan, prepare
from runtime_plan.read_plan import load
from runtime_plan.restriction import Restriction, restrict
from runtime_plan.sampler import sample
from runtime_plan.samples import Samples
from runtime_plan.samples_file import as_document, read_samples

__all__ = ["Plan", "Restriction", "Samples", "as_document", "load", "prepare", "read_samples", "restrict", "sample"]

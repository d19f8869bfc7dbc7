"""The input of the gate rules: one reading of a stage in metres and kilograms. Read `subject` first."""

from gate.subject.body import Body, Collider, VisibleSurface
from gate.subject.joint import Joint
from gate.subject.subject import Subject

__all__ = ["Body", "Collider", "Joint", "Subject", "VisibleSurface"]

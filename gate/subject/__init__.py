"""What the rules of the gate look at: one reading of a stage, in metres and kilograms."""

from gate.subject.body import Body, Collider, Surface
from gate.subject.joint import Joint
from gate.subject.subject import Subject

__all__ = ["Body", "Collider", "Joint", "Subject", "Surface"]

"""What the rules of the gate look at: one reading of a stage, in metres and kilograms."""

from usdio.subject.body import Body, Collider, Surface
from usdio.subject.joint import Joint
from usdio.subject.subject import Subject

__all__ = ["Body", "Collider", "Joint", "Subject", "Surface"]

"""Robot descriptions as files: one reader and one writer of URDF and of MJCF, with one model (`RobotDescription`)."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from formats.kinematics import link_poses
    from formats.masses import link_mass
    from formats.mjcf.read import parse_mjcf, read_mjcf
    from formats.mjcf.write import write_mjcf
    from formats.urdf.read import read_urdf
    from formats.urdf.write import write_urdf

__all__ = ["link_mass", "link_poses", "parse_mjcf", "read_mjcf", "read_urdf", "write_mjcf", "write_urdf"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "link_mass": "formats.masses",
        "link_poses": "formats.kinematics",
        "parse_mjcf": "formats.mjcf.read",
        "read_mjcf": "formats.mjcf.read",
        "read_urdf": "formats.urdf.read",
        "write_mjcf": "formats.mjcf.write",
        "write_urdf": "formats.urdf.write",
    },
)

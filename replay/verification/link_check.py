"""Compare recorded link poses with forward kinematics: largest distance (m) and angle (deg) by link."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, ConfigDict

from replay.recording.episode import Episode
from replay.recording.files.tables import column_poses, read_columns
from replay.recording.kinematics import link_poses
from schemas.arrays import FloatArray

LINK_POSES = "links_fk.parquet"
MOST_M, MOST_DEG = 1e-4, 0.1


class LinkError(BaseModel):
    """Largest distance and angle between recorded and computed pose of one link, over all samples."""

    model_config = ConfigDict(frozen=True)

    link: str
    distance_m: float
    angle_deg: float

    @property
    def agrees(self) -> bool:
        """Under 0.1 mm and 0.1 degrees."""
        return self.distance_m < MOST_M and self.angle_deg < MOST_DEG


def check_links(episode: Episode) -> tuple[LinkError, ...]:
    """One row for each link whose pose was recorded; none where the recording has no link poses."""
    file = episode.source / LINK_POSES
    if not file.is_file():
        return ()
    columns = read_columns(file)
    rows = []
    for robot in episode.robots:
        X_WL = link_poses(robot, robot.q, robot.X_WR)
        for number, link in enumerate(robot.links):
            for name in (f"{robot.name}.{link.name}", link.name):
                if f"{name}.px" in columns:
                    recorded = column_poses(columns, name, file.name)
                    rows.append(LinkError(link=name, **_largest_errors(recorded, X_WL[:, number])))
                    break
    return tuple(rows)


def _largest_errors(X: FloatArray, Y: FloatArray) -> dict[str, float]:
    """Largest distance (m) and angle (deg) between poses (n, 4, 4), row by row."""
    chord = np.linalg.norm(X[:, :3, :3] - Y[:, :3, :3], axis=(1, 2)) / np.sqrt(8.0)  # |A - B| = sqrt 8 sin(angle / 2)
    angle = 2.0 * np.arcsin(np.minimum(chord, 1.0))
    distance = np.linalg.norm(X[:, :3, 3] - Y[:, :3, 3], axis=1)
    return {"distance_m": float(distance.max()), "angle_deg": float(np.degrees(angle.max()))}

"""Released packages loaded and dropped in MuJoCo, compared with PyBullet."""

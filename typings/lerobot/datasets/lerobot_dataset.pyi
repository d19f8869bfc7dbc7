from typing import Any

CODEBASE_VERSION: str

LeRobotDataset: Any

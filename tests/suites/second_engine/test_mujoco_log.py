"""MuJoCo's warnings are logged, and leave no file behind."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

UNSTABLE = '<mujoco><worldbody><body><joint type="slide"/><geom size="0.1"/></body></worldbody></mujoco>'


def test_a_warning_is_logged_and_no_file_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    model = mujoco.MjModel.from_xml_string(UNSTABLE)
    data = mujoco.MjData(model)
    data.qvel[0] = 1e20
    mujoco.mj_step(model, data)
    assert "unstable" in caplog.text
    assert list(tmp_path.iterdir()) == []

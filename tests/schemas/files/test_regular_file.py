"""Only regular files are read; nothing keeps the reader waiting."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from schemas.files.regular_file import read_regular


def test_a_file_is_read(tmp_path: Path):
    (tmp_path / "a").write_bytes(b"x" * 100_000)
    assert read_regular(tmp_path / "a") == b"x" * 100_000


def test_everything_else_is_an_error_at_once(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    for path in (tmp_path / "pipe", tmp_path, tmp_path / "absent", tmp_path / "loop", Path("/dev/zero")):
        with pytest.raises(OSError) as refused:  # noqa: PT011
            read_regular(path)
        assert refused.value.strerror

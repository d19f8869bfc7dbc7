import zipfile
from pathlib import Path

import numpy as np
import pytest

from schemas.files.zip_damage import ZIP_DAMAGE


@pytest.mark.parametrize("packed", [False, True])
def test_nothing_else_is_raised_whatever_byte_of_an_archive_is_damaged(tmp_path: Path, packed: bool):
    whole, damaged = tmp_path / "whole.npz", tmp_path / "damaged.npz"
    (np.savez_compressed if packed else np.savez)(whole, a=np.arange(12.0), b=np.zeros((3, 2), np.uint8))
    refused = set()
    for place in range(whole.stat().st_size):
        for flipped in (0x01, 0xFF):
            data = bytearray(whole.read_bytes())
            data[place] ^= flipped
            damaged.write_bytes(data)
            try:
                with zipfile.ZipFile(damaged) as archive:
                    for name in archive.namelist():
                        archive.read(name)
            except ZIP_DAMAGE as error:
                refused.add(type(error))
    assert len(refused) >= 3

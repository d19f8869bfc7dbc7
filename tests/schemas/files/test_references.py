from pathlib import Path

import pytest

from schemas.diagnostics import InvalidInput
from schemas.files.references import resolve_reference


@pytest.fixture
def root(tmp_path: Path) -> Path:
    asset = tmp_path / "asset"
    (asset / "textures").mkdir(parents=True)
    (asset / "textures" / "Wood.PNG").write_bytes(b"x")
    (asset / "a b.bin").write_bytes(b"x")
    (tmp_path / "secret.txt").write_text("secret")
    return asset


@pytest.mark.parametrize(
    "uri",
    ["textures/Wood.PNG", "./textures/Wood.PNG", "textures\\Wood.PNG", ".\\textures\\wood.png", "TEXTURES/WOOD.png"],
)
def test_spellings_of_one_file(root: Path, uri: str):
    assert resolve_reference(uri, base=root, root=root) == (root / "textures" / "Wood.PNG").resolve()


def test_percent_encoding_is_decoded(root: Path):
    assert resolve_reference("a%20b.bin", base=root, root=root) == (root / "a b.bin").resolve()


def test_upwards_inside_the_root_is_legal(root: Path):
    assert resolve_reference("../a b.bin", base=root / "textures", root=root) is not None


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.txt",
        "%2e%2e/secret.txt",
        "..\\secret.txt",
        "textures/../../secret.txt",
        "/etc/passwd",
        "file:///etc/passwd",
        "../absent.txt",
    ],
)
def test_escapes_are_refused_whether_or_not_the_file_exists(root: Path, uri: str):
    with pytest.raises(InvalidInput) as refused:
        resolve_reference(uri, base=root, root=root)
    assert refused.value.diagnostic.code == "asset/path-escape"


def test_a_link_out_of_the_root_is_an_escape(root: Path):
    (root / "link.txt").symlink_to(root.parent / "secret.txt")
    with pytest.raises(InvalidInput) as refused:
        resolve_reference("link.txt", base=root, root=root)
    assert refused.value.diagnostic.code == "asset/path-escape"


@pytest.mark.parametrize("uri", ["http://127.0.0.1:9/x.bin", "HTTPS://host/x.png", "omniverse://host/x.usd"])
def test_network_addresses_are_refused(root: Path, uri: str):
    with pytest.raises(InvalidInput) as refused:
        resolve_reference(uri, base=root, root=root)
    assert refused.value.diagnostic.code == "asset/remote-reference"


@pytest.mark.parametrize(
    "uri",
    [
        *("C:\\Users\\bob\\wood.png", "file:///C:/wood.png", "\\\\server\\wood.png", "file://..\\LWO\\wood.jpg", ""),
        *("http://[::1", "file://[x", "x" * 5000, "a\ud800.png", "a\x00b"),
    ],
)
def test_paths_of_another_machine_are_absent_not_opened(root: Path, uri: str):
    assert resolve_reference(uri, base=root, root=root) is None


def test_absent_file_inside_the_root_is_none(root: Path):
    assert resolve_reference("textures/none.png", base=root, root=root) is None

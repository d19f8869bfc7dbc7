"""No file outside the root is read, whatever a USD file refers to, and every bad file gives a located finding."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import pytest

from schemas.diagnostics import Diagnostic, InvalidInput
from usdio.quiet import quiet
from usdio.read import usdz
from usdio.read.asset import read_stage
from usdio.read.layer_guard import check_layers

CUBE = """#usda 1.0
(
    defaultPrim = "Root"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "Root" {
    def Cube "Cube" {}
    %s
}
"""
SECRET = '#usda 1.0\n(\n defaultPrim = "Root"\n)\ndef Sphere "Root" {\n double radius = 77\n}\n'


def no_textures(data: bytes, name: str, *, where: object) -> tuple[None, tuple[Diagnostic, ...]]:
    return None, ()


def asset(folder: Path, body: str = "", name: str = "part.usda") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(CUBE % body)
    return path


def read(path: Path, root: Path | None = None):
    return read_stage(path, root or path.parent, load_texture=no_textures)


def rejection(path: Path, root: Path | None = None) -> Diagnostic:
    with pytest.raises(InvalidInput) as caught:
        read(path, root)
    return caught.value.diagnostic


def extents(path: Path, root: Path | None = None) -> list[float]:
    model = read(path, root).value
    assert model is not None
    return sorted(float(mesh.points.max()) for mesh in model.meshes)


ESCAPES = [
    'def "x" (references = @../secret.usda@) {}',
    'def "x" (payload = @../secret.usda@) {}',
    'def "x" (references = @..\\secret.usda@) {}',
    'def "x" (references = @%2e%2e/secret.usda@) {}',
    'def "x" (variantSets = "v") {\n variantSet "v" = { "a" {\n def "y" (references = @../secret.usda@) {}\n }\n }\n }',
    'def "x" (clips = {\n dictionary default = {\n asset[] assetPaths = [@../secret.usda@]\n }\n }) {}',
    "asset inputs:file = @../secret.png@",
    "asset[] inputs:files = [@./in.png@, @../secret.png@]",
    "asset inputs:file.timeSamples = { 0: @../secret.png@ }",
    'def "x" (references = @`"../secret.usda"`@) {}',
]


@pytest.mark.parametrize("body", ESCAPES)
def test_a_reference_out_of_the_root_rejects_the_asset(tmp_path: Path, body: str) -> None:
    (tmp_path / "secret.usda").write_text(SECRET)
    (tmp_path / "secret.png").write_bytes(b"")
    diagnostic = rejection(asset(tmp_path / "root", body))
    assert diagnostic.code == "asset/path-escape"
    assert diagnostic.where.file == "part.usda"


def test_absolute_paths_and_symbolic_links_out_of_the_root_are_escapes(tmp_path: Path) -> None:
    (tmp_path / "secret.usda").write_text(SECRET)
    absolute = asset(tmp_path / "a", f'def "x" (references = @{tmp_path}/secret.usda@) {{}}')
    linked = asset(tmp_path / "b", 'def "x" (references = @./link.usda@) {}')
    (tmp_path / "b" / "link.usda").symlink_to(tmp_path / "secret.usda")
    assert rejection(absolute).code == "asset/path-escape"
    assert rejection(linked).code == "asset/path-escape"


def test_a_search_path_never_finds_a_layer_in_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outside = tmp_path / "elsewhere"
    outside.mkdir()
    (outside / "secret.usda").write_text(SECRET)
    monkeypatch.chdir(outside)
    monkeypatch.setenv("PXR_AR_DEFAULT_SEARCH_PATH", str(outside))
    path = asset(tmp_path / "root", 'def "x" (references = @secret.usda@) {}')
    outcome = read(path)
    assert extents(path) == [1.0]
    assert [d.code for d in outcome.diagnostics] == ["asset/missing-dependency"]
    assert [r.name for r in outcome.repairs] == ["missing_dependency"]


def test_one_file_named_by_every_kind_of_arc_is_pinned_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # OpenUSD's own rewriting stops at the sublayer; the references beside it once reached the working directory.
    outside = tmp_path / "elsewhere"
    outside.mkdir()
    (outside / "secret.usda").write_text(SECRET)
    monkeypatch.chdir(outside)
    arcs = "references = @secret.usda@\n payload = @secret.usda@"
    variant = f'variantSet "v" = {{ "a" ({arcs}) {{\n def "y" ({arcs}) {{}}\n }}\n }}'
    selected = 'variantSets = "v"\n variants = { string v = "a" }'
    body = f'def "x" ({arcs}\n {selected}) {{\n {variant}\n }}'
    path = asset(tmp_path / "root", body)
    path.write_text(path.read_text().replace("upAxis", "subLayers = [@secret.usda@]\n upAxis"))
    assert extents(path) == [1.0]
    with quiet():
        layers = check_layers(path, path.parent)
    assert all(uri.startswith("anon:") for layer in layers.copies for uri in layer.GetCompositionAssetDependencies())


def test_a_reference_through_the_parent_inside_the_root_is_legal(tmp_path: Path) -> None:
    asset(tmp_path / "geo", name="ball.usda")
    path = asset(tmp_path / "asset", 'def "x" (references = @../geo/ball.usda@</Root>) {}')
    assert extents(path, tmp_path) == [1.0, 1.0]


@pytest.mark.parametrize("uri", [r".\geo\ball.usda", "geo/ball%2eusda", "GEO/Ball.usda"])
def test_windows_separators_percent_encoding_and_letter_case_are_understood(tmp_path: Path, uri: str) -> None:
    asset(tmp_path / "geo", name="ball.usda")
    path = asset(tmp_path, f'def "x" (references = @{uri}@</Root>) {{}}')
    outcome = read(path)
    assert outcome.value is not None
    assert len(outcome.value.meshes) == 2
    assert outcome.diagnostics == ()


def test_a_network_address_is_never_fetched(tmp_path: Path) -> None:
    for index, uri in enumerate(("https://example.org/x.usd", "omniverse://localhost/x.usd")):
        path = asset(tmp_path / str(index), f'def "x" (references = @{uri}@) {{}}')
        assert rejection(path).code == "asset/remote-reference"


CYCLES = [
    'def "x" (references = @part.usda@</Root>) {}',
    'def "x" (references = @./part.usda@) {}',
    'def "x" (references = </Root>) {}',
    'def "x" (references = </Root/x>) {}',
    'def "x" (references = </Root/y>) {}\n def "y" (references = </Root/x>) {}',
    'def "x" (references = @other.usda@</Root>) {}',
]


@pytest.mark.parametrize("body", CYCLES)
def test_a_prim_that_contains_itself_is_a_cycle(tmp_path: Path, body: str) -> None:
    asset(tmp_path, 'def "x" (references = @part.usda@</Root>) {}', name="other.usda")
    assert rejection(asset(tmp_path, body)).code == "asset/cyclic-reference"


def test_layers_that_sublayer_each_other_are_a_cycle(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text("#usda 1.0\n(\n subLayers = [@b.usda@]\n)\n")
    (tmp_path / "b.usda").write_text("#usda 1.0\n(\n subLayers = [@./a.usda@]\n)\n")
    diagnostic = rejection(tmp_path / "a.usda")
    assert diagnostic.code == "asset/cyclic-reference"
    assert "a.usda" in str(diagnostic.value)


def test_two_layers_may_use_different_prims_of_each_other(tmp_path: Path) -> None:
    asset(tmp_path, 'def "x" (references = @part.usda@</Root/Cube>) {}', name="other.usda")
    assert extents(asset(tmp_path, 'def "x" (references = @other.usda@</Root/x>) {}')) == [1.0, 1.0]


def test_an_absent_layer_is_a_warning_beside_geometry_and_an_error_without(tmp_path: Path) -> None:
    with_cube = read(asset(tmp_path, 'def "x" (payload = @gone.usd@) {}'))
    assert [(d.code, d.severity) for d in with_cube.diagnostics] == [("asset/missing-dependency", "warning")]
    empty = tmp_path / "empty.usda"
    empty.write_text('#usda 1.0\ndef Xform "Root" (payload = @gone.usd@) {}\n')
    diagnostic = rejection(empty)
    assert (diagnostic.code, diagnostic.value) == ("asset/missing-dependency", "gone.usd")


def test_an_absent_layer_in_a_variant_that_is_not_selected_is_no_finding(tmp_path: Path) -> None:
    variants = 'variantSet "v" = {\n "a" {\n }\n "b" {\n def "y" (references = @gone.usda@) {}\n }\n }'
    body = 'def "x" (variants = {\n string v = "%s"\n }\n variantSets = "v") {\n ' + variants + "\n }"
    assert read(asset(tmp_path / "a", body % "a")).diagnostics == ()
    assert [d.code for d in read(asset(tmp_path / "b", body % "b")).diagnostics] == ["asset/missing-dependency"]


def test_variable_expressions_are_evaluated(tmp_path: Path) -> None:
    asset(tmp_path, name="ball.usda")
    path = asset(tmp_path, 'def "x" (references = @`"${NAME}.usda"`@</Root>) {}')
    path.write_text(path.read_text().replace("upAxis", 'expressionVariables = { string NAME = "ball" }\n upAxis'))
    assert extents(path) == [1.0, 1.0]


def test_a_syntax_error_names_its_line_and_column(tmp_path: Path) -> None:
    path = asset(tmp_path, 'def Mesh "m" {\n  int[] faceVertexCounts = [3, oops]\n }')
    diagnostic = rejection(path)
    assert diagnostic.code == "asset/parse-error"
    assert diagnostic.where.line == 1 + path.read_text()[: path.read_text().index("oops")].count("\n")
    assert diagnostic.where.column is not None
    assert "pxr" not in str(diagnostic.value)


def test_damaged_and_foreign_bytes_are_told_apart(tmp_path: Path) -> None:
    whole = (CUBE % "").encode()
    crate = b"PXR-USDC" + bytes(8) + struct.pack("<q", 10**6) + bytes(64)
    cases = {
        "text.usda": (whole[: len(whole) // 2], "asset/truncated"),
        "empty.usda": (b"", "asset/truncated"),
        "crate.usdc": (crate, "asset/truncated"),
        "page.usda": (b"<!DOCTYPE html><html></html>", "asset/wrong-content"),
        "binary.usd": (b"\x00\x01\x02\x03" * 8, "asset/wrong-content"),
        "pointer.usd": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "asset/lfs-pointer"),
    }
    for name, (data, code) in cases.items():
        (tmp_path / name).write_bytes(data)
        assert rejection(tmp_path / name).code == code, name


def test_a_bad_layer_deep_inside_is_located_there(tmp_path: Path) -> None:
    (tmp_path / "page.usd").write_text("<html></html>")
    diagnostic = rejection(asset(tmp_path, 'def "x" (references = @page.usd@) {}'))
    assert (diagnostic.code, diagnostic.where.file) == ("asset/wrong-content", "page.usd")


def test_material_x_includes_stay_inside_the_root(tmp_path: Path) -> None:
    root = tmp_path / "root"
    path = asset(root, 'def "x" (references = @look.mtlx@) {}')
    include = '<include xmlns="http://www.w3.org/2001/XInclude" href="../secret.mtlx"/>'
    (root / "look.mtlx").write_text(f'<materialx version="1.38">{include}</materialx>')
    (tmp_path / "secret.mtlx").write_text("<materialx/>")
    assert rejection(path).code == "asset/path-escape"
    (root / "look.mtlx").write_text("<materialx>")
    assert rejection(path).code == "asset/parse-error"


def package(path: Path, entries: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return path


def test_a_package_reads_its_layers_from_within(tmp_path: Path) -> None:
    inner = (CUBE % 'def "x" (references = @./geo/ball.usda@</Root>) {}').encode()
    ball = (CUBE % "").encode()
    path = package(tmp_path / "part.usdz", {"part.usda": inner, "geo/ball.usda": ball})
    assert extents(path) == [1.0, 1.0]
    outer = asset(
        tmp_path, 'def "x" (references = @part.usdz@</Root>) {}\n def "y" (references = @part.usdz[geo/ball.usda]@) {}'
    )
    assert extents(outer) == [1.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("entries", "compression", "code"),
    [
        ({"part.usda": b"#usda 1.0", "../evil.usda": b""}, zipfile.ZIP_STORED, "asset/path-escape"),
        ({"/evil.usda": b"#usda 1.0"}, zipfile.ZIP_STORED, "asset/path-escape"),
        ({"a\\..\\..\\evil.usda": b"#usda 1.0"}, zipfile.ZIP_STORED, "asset/path-escape"),
        ({"part.usda": b"#usda 1.0", "pad.png": bytes(10**6)}, zipfile.ZIP_DEFLATED, "asset/resource-limit"),
        ({"readme.txt": b"no layer"}, zipfile.ZIP_STORED, "asset/wrong-content"),
    ],
)
def test_packages_that_break_the_rules(tmp_path: Path, entries: dict, compression: int, code: str) -> None:
    assert rejection(package(tmp_path / "part.usdz", entries, compression)).code == code


def test_a_package_may_not_unpack_beyond_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usdz, "MAX_BYTES", 1000)
    diagnostic = rejection(package(tmp_path / "part.usdz", {"part.usda": b"#usda 1.0\n" + b"# pad\n" * 200}))
    assert diagnostic.code == "asset/resource-limit"


def test_cut_and_encrypted_packages(tmp_path: Path) -> None:
    path = package(tmp_path / "part.usdz", {"part.usda": (CUBE % "").encode(), "pad.png": bytes(500)})
    data = bytearray(path.read_bytes())
    path.write_bytes(data[: len(data) // 2])
    assert rejection(path).code == "asset/truncated"
    directory = data.index(b"PK\x01\x02")
    data[directory + 8] |= 1  # the general-purpose flag "encrypted" of the first entry
    path.write_bytes(data)
    assert rejection(path).code == "asset/resource-limit"
    path.write_bytes(b"no archive")
    assert rejection(path).code == "asset/wrong-content"


def test_nothing_reaches_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    read(asset(tmp_path, 'def "x" (references = @gone.usda@) {}\n def "y" (references = </Root/absent>) {}'))
    rejection(asset(tmp_path, "oops"))
    assert capfd.readouterr() == ("", "")


def test_layers_are_private_copies(tmp_path: Path) -> None:
    path = asset(tmp_path, 'def "x" (references = @ball.usda@</Root>) {}')
    asset(tmp_path, name="ball.usda")
    with quiet():
        first, second = check_layers(path, tmp_path), check_layers(path, tmp_path)
    assert len(first.locations) == len(second.locations) == 2
    assert not set(first.locations) & set(second.locations)
    assert extents(path) == [1.0, 1.0]
    path.write_text(CUBE % "")
    assert extents(path) == [1.0]


def test_text_that_is_not_utf8_is_a_finding(tmp_path: Path) -> None:
    path = asset(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"upAxis", b'doc = "\xe4\xf6"\n upAxis'))
    assert rejection(path).code == "asset/parse-error"

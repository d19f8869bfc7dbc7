"""Diagnostic codes of geometry and appearance; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

SHAPE_CODES: dict[str, CodeInfo] = {
    # Geometry, repaired.
    "asset/far-from-origin": CodeInfo(
        "warning",
        "The object lies far from its origin",
        "In single precision its shape would be rounded away; it was moved home in double precision.",
        "nothing; the frame now sits at the object's bottom centre",
    ),
    "asset/inverted-winding": CodeInfo(
        "warning",
        "Faces are wound inside out",
        "Volume, mass and lighting come out wrong.",
        "nothing; the faces were turned to point outwards",
    ),
    "asset/degenerate-faces": CodeInfo(
        "warning",
        "Faces have zero area or occur twice",
        "They break normals, volume and collision libraries.",
        "nothing; they were removed",
    ),
    "asset/small-holes": CodeInfo(
        "warning",
        "A nearly closed surface has holes",
        "An open surface has no volume, so mass and collision would be guesses.",
        "nothing; the holes were filled, compare the pictures",
    ),
    "asset/non-manifold-edge": CodeInfo(
        "warning",
        "More than two faces share an edge",
        "Inside and outside are undefined there.",
        "nothing; the surplus faces were removed from the physical surface",
    ),
    "asset/non-manifold-left": CodeInfo(
        "info",
        "Edges with more than two faces are left",
        "Boards that meet and sheets drawn from both sides look so by design; tools for closed surfaces refuse them.",
        "separate the parts, or draw each surface once, if the render mesh itself is to be manifold",
    ),
    "asset/non-manifold-vertex": CodeInfo(
        "warning",
        "Two surfaces touch in a single point",
        "The point belongs to two solids, which topology tools reject.",
        "nothing; the point was split",
    ),
    "asset/duplicate-shell": CodeInfo(
        "warning",
        "The same closed surface occurs more than once",
        "Volume and mass would count it each time.",
        "nothing; the copies were removed",
    ),
    "asset/overlapping-bodies": CodeInfo(
        "warning",
        "Closed parts overlap",
        "The shared volume would be counted twice.",
        "nothing; mass uses the union of the parts",
    ),
    "asset/open-shell": CodeInfo(
        "warning",
        "The surface is a thin sheet with a large opening",
        "Closing it would turn a container into a block, so it stays a shell of assumed wall thickness.",
        "state the wall with --shell-thickness, give it a thickness in the source, or accept the assumed one",
    ),
    "asset/dirty-mesh": CodeInfo(
        "warning",
        "The mesh has several topological defects at once",
        "Duplicate, degenerate or crossing faces together make single repairs meaningless; it was rebuilt.",
        "nothing; compare the distance figures in the record",
    ),
    "asset/loose-fragments": CodeInfo(
        "warning",
        "Tiny pieces float beside the object",
        "Debris of scanning or modelling stretches the bounding box and becomes matter that is not there.",
        "nothing; they were removed, count, area and largest size are in the record",
    ),
    "asset/self-intersection": CodeInfo(
        "warning",
        "A closed surface passes through itself",
        "Volume, mass centre and inertia count the doubled parts twice and the inverted ones as holes.",
        "nothing; the physical surface was resolved, the visible one is as it was",
    ),
    "asset/repair-distorts": CodeInfo(
        "warning",
        "A repair may have changed the shape",
        "The surface may lie more than 1 % of the diagonal from the true one, and no figure can tell which is right.",
        "compare source and package at the place named: accept the repaired shape, or mend the source and ingest again",
    ),
    "asset/too-many-triangles": CodeInfo(
        "warning",
        "The mesh is heavier than the budget",
        "Simulators and viewers slow down far below this size.",
        "nothing; it was reduced, the surface error is in the record",
    ),
    "asset/bad-normals": CodeInfo(
        "warning",
        "Normals are zero, not unit length, not finite, or look inwards",
        "Shading would be black or random.",
        "nothing; normals were recomputed from the faces or turned",
    ),
    "asset/empty-face": CodeInfo(
        "warning",
        "A face record has fewer than three corners",
        "The face was meant to exist, so the surface has a gap there.",
        "export the mesh again; check the line named",
    ),
    "asset/nonfinite-colors": CodeInfo(
        "warning",
        "A vertex colour is NaN or infinite",
        "Renderers show it as black or noise.",
        "nothing; vertex colours were dropped or replaced",
    ),
    # Appearance.
    "asset/missing-texture": CodeInfo(
        "warning",
        "A texture file is absent",
        "The surface loses its picture; its scalar colour is used instead.",
        "put the file named beside the asset",
    ),
    "asset/corrupt-texture": CodeInfo(
        "warning",
        "A texture cannot be decoded",
        "The surface loses its picture; its scalar colour is used instead.",
        "replace the image named",
    ),
    "asset/unsupported-texture": CodeInfo(
        "warning",
        "A texture is in a format that cannot be decoded here",
        "KTX2 and similar containers need a GPU transcoder; a fallback image or the scalar colour is used.",
        "add a PNG or JPEG fallback",
    ),
    "asset/missing-material": CodeInfo(
        "warning",
        "A material library or material is absent",
        "The surface has no stated look; a neutral grey is used.",
        "put the .mtl file beside the asset",
    ),
    "asset/appearance-recovered": CodeInfo(
        "info",
        "A surface without a trustworthy appearance got plausible values",
        "Its look is inferred from names, category and shape, or the most usual one; it is no evidence on the object.",
        "state the material in the source, or leave `--recover-appearance` out; see `appearance.recovered`",
    ),
    "asset/appearance-generator-failed": CodeInfo(
        "warning",
        "The generator of materials gave no usable answer, or proposals of its answer were left out",
        "Degraded surfaces are filled in from the library alone, or from what is left.",
        "check the answer against the form in docs/explanation/appearance-recovery.md",
    ),
    "asset/invalid-material-value": CodeInfo(
        "warning",
        "A material value cannot be read or is out of range",
        "Shaders give undefined results outside the allowed range.",
        "nothing; the value was replaced by the default or clamped",
    ),
    "asset/material-extension-fallback": CodeInfo(
        "info",
        "A material feature has no counterpart in any shader of the package",
        "The look may differ; the source values are kept in the record.",
        "nothing; see `appearance` in the record",
    ),
    "asset/normal-map-green-down": CodeInfo(
        "info",
        "Green of a normal map points down along v, as DirectX has it",
        "Bumps would be lit as dents. A map whose format leaves the way open is turned; one whose format defines green "
        "as up is kept, since it may only look so.",
        "look at the surface under a lamp; invert the green channel of the source where the map was kept and is wrong",
    ),
    "asset/shader-lacks-layer": CodeInfo(
        "info",
        "One of the shaders of a material cannot show all of it",
        "A renderer that reads this shader shows a simpler surface than one that reads the others.",
        "nothing, or render with OpenPBR; see `appearance.render_materials` in the record",
    ),
    "asset/missing-texture-coordinates": CodeInfo(
        "warning",
        "A textured mesh has no texture coordinates for its picture",
        "The surface takes one colour of the picture instead of the picture.",
        "unwrap the mesh, or remove the texture from its material",
    ),
    "asset/collapsed-texture-coordinates": CodeInfo(
        "warning",
        "The texture coordinates of a textured mesh lie in one point",
        "The surface takes one colour of the picture instead of the picture.",
        "unwrap the mesh again",
    ),
    "asset/nonfinite-texture-coordinates": CodeInfo(
        "warning",
        "Texture coordinates are NaN or infinite",
        "Renderers show noise or black there.",
        "nothing; they were replaced by zero",
    ),
    "asset/texture-resampled": CodeInfo(
        "info",
        "A texture was made smaller to keep to the budget",
        "The package takes less memory; fine detail is lost.",
        "raise --max-texture to keep more of it",
    ),
    "asset/retopology": CodeInfo(
        "info",
        "A light mesh with baked maps was released in place of a heavy one",
        "It looks alike within the bounds and simulates and draws in a fraction of the time; relief is a normal map.",
        "nothing; leave out --retopo to keep the source mesh, or raise its number of faces",
    ),
    "asset/retopology-unlike-source": CodeInfo(
        "warning",
        "A light mesh does not look like its source, so the source mesh is kept",
        "Silhouettes or colours in the standard views differ by more than the bound.",
        "raise the number of faces of --retopo",
    ),
    "asset/retopology-skipped": CodeInfo(
        "info",
        "The source mesh is kept, no light one was made",
        "It has no more triangles than wanted, its materials need their own texture coordinates, or a library ended.",
        "nothing, or state fewer faces with --retopo",
    ),
    "asset/baked-lighting-suspected": CodeInfo(
        "info",
        "The base colour seems to hold light and shadow",
        "A scene lights the object a second time: it looks dark below whatever the lamps do.",
        "use a source without baked light, or remove the light from the texture",
    ),
    "asset/name-sanitised": CodeInfo(
        "info",
        "Names were changed to be valid identifiers",
        "USD prim names allow letters, digits and underscores only, each once per parent.",
        "nothing; the source names are kept beside the new ones",
    ),
    "asset/animation-dropped": CodeInfo(
        "info",
        "The source is animated",
        "An asset is static; its first frame was taken.",
        "nothing, or export the pose you want",
    ),
}

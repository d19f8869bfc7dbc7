"""Every diagnostic code, in one explicit table. Each has a page under `docs/diagnostics/` made from its row
(`python -m cli.docs`) and a smallest bad input in `tests/bad_inputs.py`; one test proves that the three agree.

A code names the pattern found, never the remedy. Codes are stable: extend, never rename.
"""

from __future__ import annotations

from schemas.code_info import CodeInfo
from schemas.gap_codes import GAP_CODES
from schemas.gate_codes import GATE_CODES
from schemas.plan_codes import PLAN_CODES
from schemas.replay_codes import REPLAY_CODES
from schemas.scene_codes import SCENE_CODES

CODES: dict[str, CodeInfo] = {
    # Intake: the file itself.
    "asset/format-unsupported": CodeInfo(
        "error",
        "The file type is not one Mana reads",
        "Only GLB, glTF, OBJ, STL, PLY, DAE and USD files become assets; anything else is reported, not guessed at.",
        "convert the file to GLB or USD and ingest that",
    ),
    "asset/format-unsupported-yet": CodeInfo(
        "error",
        "The file type is planned but not read yet",
        "URDF, MJCF and .blend carry joints or node graphs that a mesh import would silently drop.",
        "export the geometry as GLB or USD, or wait for the articulated-asset release",
    ),
    "asset/wrong-content": CodeInfo(
        "error",
        "The bytes are not what the file name says",
        "An HTML error page or another format under this extension would be misread as geometry.",
        "download the file again or give it its true extension",
    ),
    "asset/lfs-pointer": CodeInfo(
        "error",
        "The file is a git-LFS pointer, not the asset",
        "The real bytes were never fetched, so there is no geometry to read.",
        "run `git lfs pull` in the source repository and ingest again",
    ),
    "asset/parse-error": CodeInfo(
        "error",
        "The file cannot be parsed",
        "A parser that guesses past a syntax error invents geometry.",
        "open the file in the tool that wrote it and export it again",
    ),
    "asset/schema-error": CodeInfo(
        "error",
        "A value has the wrong type for its format",
        "The file parses but breaks the rules of its format, so its meaning is unknown.",
        "validate the file with its format's own checker and export it again",
    ),
    "asset/truncated": CodeInfo(
        "error",
        "The file ends before its content does",
        "Part of the geometry is missing; what remains is not the object.",
        "download or copy the file again",
    ),
    "asset/accessor-out-of-bounds": CodeInfo(
        "error",
        "An accessor reads past the end of its buffer",
        "The declared count does not fit the data; following it would read foreign memory or allocate without limit.",
        "export the file again; the declared counts are wrong",
    ),
    "asset/index-out-of-range": CodeInfo(
        "error",
        "A face refers to a point that does not exist",
        "The face has no defined position. Single stray faces are dropped; more reject the file.",
        "export the mesh again or remove the faces named",
    ),
    "asset/missing-dependency": CodeInfo(
        "error",
        "A file that holds geometry is absent",
        "Without the referenced buffer or layer there is nothing to build.",
        "put the missing file beside the asset",
    ),
    "asset/cyclic-reference": CodeInfo(
        "error",
        "The hierarchy or a reference contains itself",
        "A cycle has no finite expansion.",
        "break the cycle at the location named",
    ),
    "asset/unsupported-required-extension": CodeInfo(
        "error",
        "The file requires an extension Mana does not know",
        "The author states that the file cannot be read correctly without it.",
        "export without the extension",
    ),
    "asset/path-escape": CodeInfo(
        "error",
        "A reference leads out of the asset's folder",
        "Following it could read any file on the machine; it is never opened.",
        "move the referenced file into the asset's folder, or widen the root with --root",
    ),
    "asset/remote-reference": CodeInfo(
        "error",
        "A reference is a network address",
        "Ingestion works offline and never fetches what an asset names.",
        "download the file, put it beside the asset and change the reference",
    ),
    "asset/resource-limit": CodeInfo(
        "error",
        "Reading the file would exceed a resource limit",
        "Decompression, entity and texture bombs take the whole batch down; limits stop them.",
        "make the named item smaller, or raise the limit if you trust the source",
    ),
    "asset/worker-crashed": CodeInfo(
        "error",
        "The worker process died",
        "A native library aborted on this input; the batch goes on without it.",
        "see the last lines in the report; simplify or clean the mesh and ingest again",
    ),
    "asset/worker-timeout": CodeInfo(
        "error",
        "The worker ran past its time limit",
        "A stage hung or the asset is too heavy for the limit; the worker was stopped.",
        "raise --timeout or reduce the asset",
    ),
    "asset/worker-out-of-memory": CodeInfo(
        "error",
        "The worker ran past its memory limit",
        "The asset needs more memory than one worker may use.",
        "raise --memory or reduce the asset",
    ),
    # Intake: the content.
    "asset/empty-geometry": CodeInfo(
        "error",
        "The file holds no geometry",
        "There is nothing to simulate.",
        "check that the export included the mesh",
    ),
    "asset/no-faces": CodeInfo(
        "error",
        "The file has points or lines but no faces",
        "Points and lines have no surface; a surface would have to be invented.",
        "reconstruct a surface first, then ingest the mesh",
    ),
    "asset/nonfinite-vertices": CodeInfo(
        "error",
        "A coordinate is NaN or infinite",
        "One such point poisons bounds, mass and collision.",
        "find and fix the vertex named",
    ),
    "asset/degenerate-geometry": CodeInfo(
        "error",
        "Every face has zero area",
        "No surface remains once degenerate faces are removed.",
        "export the mesh again; its faces have collapsed",
    ),
    "asset/triangle-soup": CodeInfo(
        "error",
        "The triangles share no edges",
        "Unconnected random triangles bound no object.",
        "weld or reconstruct the surface first",
    ),
    "asset/scale-implausible": CodeInfo(
        "error",
        "The size is impossible for a robot-simulation asset",
        "No unit hypothesis gives an object between 0.1 mm and 10 km.",
        "say the unit with --units mm|cm|m|in",
    ),
    "asset/several-objects": CodeInfo(
        "warning",
        "The file seems to hold several separate objects",
        "Far-apart pieces are usually a scene; one rigid body would tie them together.",
        "split the file into one object each, or confirm that it is one object",
    ),
    "asset/articulated-source": CodeInfo(
        "warning",
        "The source declares joints, which this release does not carry over",
        "One rigid body would silently lock them.",
        "wait for the articulated-asset release, or ingest the links one by one",
    ),
    # Units and axes.
    "asset/unit-mismatch": CodeInfo(
        "warning",
        "The numbers are not in the unit the format implies",
        "Named evidence (comment, file name, size) shows another unit; the asset was rescaled.",
        "check the size in the report; override with --units",
    ),
    "asset/scale-unverified": CodeInfo(
        "warning",
        "Nothing confirms the metric size",
        "The format declares no unit, or the declared size is unusual; the size is provisional.",
        "say the unit with --units mm|cm|m|in",
    ),
    "asset/turned-upright": CodeInfo(
        "warning",
        "The object did not stand in its reference pose",
        "Scenes place objects as they stand: a mug on its side would be put down on its side, and its opening missed.",
        "nothing, or state the axis with --up-axis where the object is meant to lie",
    ),
    "asset/upright-uncertain": CodeInfo(
        "warning",
        "The object probably does not stand as its file has it",
        "Form and category speak for another way up, but not clearly enough to turn the object.",
        "look at the pictures and state the axis with --up-axis",
    ),
    "asset/up-axis-mismatch": CodeInfo(
        "warning",
        "The object stands along another axis than the format implies",
        "Named evidence shows another up axis; the asset was turned.",
        "check the pictures in the report",
    ),
    "asset/up-axis-unverified": CodeInfo(
        "info",
        "Nothing states which way is up",
        "The format has no up axis and no text names one, so the habit of such files was taken.",
        "check the pictures in the report; override with --up-axis",
    ),
    "asset/contradictory-evidence": CodeInfo(
        "warning",
        "Statements about unit or up axis contradict each other or the size",
        "One of them is wrong. The stronger one was used where there is one; otherwise the asset goes to review.",
        "say the truth with --units or --up-axis",
    ),
    "asset/invalid-unit-value": CodeInfo(
        "error",
        "The declared unit is not a positive number",
        "A zero, negative or unreadable unit gives no size.",
        "correct the unit in the source file",
    ),
    "asset/invalid-up-axis": CodeInfo(
        "warning",
        "The declared up axis is not allowed by the format",
        "USD allows Y and Z only; other tools will read the file differently.",
        "set upAxis to Y or Z in the source file",
    ),
    "asset/invalid-default-prim": CodeInfo(
        "warning",
        "defaultPrim names a prim that does not exist",
        "References to the file would bring in nothing; the whole stage was read instead.",
        "correct defaultPrim in the source file",
    ),
    "asset/geometry-left-out": CodeInfo(
        "warning",
        "Geometry without triangles was left out",
        "Curved patches, tetrahedra, lines and points are no triangle surface; the asset is made from the rest.",
        "convert what is missing to a mesh, if it belongs to the object",
    ),
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
    "asset/invalid-material-value": CodeInfo(
        "warning",
        "A material value cannot be read or is out of range",
        "Shaders give undefined results outside the allowed range.",
        "nothing; the value was replaced by the default or clamped",
    ),
    "asset/material-extension-fallback": CodeInfo(
        "info",
        "A material feature has no counterpart in UsdPreviewSurface",
        "The look may differ; the source values are kept in the record.",
        "nothing; see `appearance.unmapped` in the record",
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
    # Semantics.
    "asset/category-unknown": CodeInfo(
        "info",
        "Nothing tells what kind of thing the object is",
        "Names are silent, ambiguous or contradicted, and shape alone proves nothing; `unknown` beats a guess.",
        "say it with --category, or give the file or its folder a telling name",
    ),
    "asset/category-contradicted": CodeInfo(
        "warning",
        "The stated or named category does not fit the object",
        "Size, form or other names speak against it: the unit, the name or the statement is wrong, or it is a toy.",
        "check the size in the report, and say the truth with --units or --category",
    ),
    "asset/annotator-unreachable": CodeInfo(
        "warning",
        "The multimodal annotator could not be asked",
        "The endpoint was not found, stayed silent or busy, or does not know the key or the model; what the object is "
        "was told without it, from names and shape.",
        "check --annotator-url, --annotator-model and the key in MANA_ANNOTATOR_KEY, then run the same command again",
    ),
    "asset/annotator-failed": CodeInfo(
        "warning",
        "The multimodal annotator gave no usable answer",
        "The endpoint refused this question or answered something else than it was asked; what the object is was told "
        "without it, from names and shape.",
        "choose a model that sees pictures and keeps to a JSON Schema, then run the same command again",
    ),
    "asset/annotator-refused": CodeInfo(
        "warning",
        "The multimodal annotator said something outside the vocabulary",
        "Scenes rely on the controlled vocabulary; whatever else a model says is left out.",
        "nothing, or state the category with --category; an endpoint that keeps to JSON Schema does not do this",
    ),
    "asset/category-outside-vocabulary": CodeInfo(
        "info",
        "The stated category is not in the vocabulary",
        "It is kept as stated, but no family, roles, usual size or Wikidata class belong to it.",
        "nothing, or state a category of docs/pipelines/semantics.md",
    ),
    "asset/part-disputed": CodeInfo(
        "warning",
        "Clues about the name of a part contradict each other",
        "Names and shape, or two names, say different things, or what should lie above lies below; the part stays in "
        "the record without a label.",
        "look at previews/parts.png, and name nodes and materials in the source after what they are",
    ),
    "asset/segmenter-failed": CodeInfo(
        "warning",
        "The segmenter gave no usable answer, or only a part of one",
        "Its regions, or some of them, are missing; parts are found from names, materials, pieces and shape alone.",
        "run the command by hand on a surface, see docs/pipelines/parts.md, or give it more time with "
        "--segmenter-timeout; it is asked anew when a file of the command changed, or with --fresh",
    ),
    # Decisions of people.
    "asset/decided-by-person": CodeInfo(
        "info",
        "A person decided about this asset",
        "What was decided is declared evidence or an answer to a question of review; the finding says who and why.",
        "nothing, or overrule it with a later decision: mana assets review",
    ),
    "asset/decision-overruled": CodeInfo(
        "info",
        "Two statements about an asset contradict each other",
        "The last decision of a person wins, over earlier ones and over what the command line says of the whole batch.",
        "nothing, or record another decision: mana assets review",
    ),
    "asset/decision-outdated": CodeInfo(
        "warning",
        "A decision of a person does not cover the asset as it is now",
        "The file or what it refers to has changed, or findings appeared that the person did not know of.",
        "look again and decide anew: mana assets review",
    ),
    "asset/decision-unreadable": CodeInfo(
        "error",
        "The file of decisions has a line that is no decision",
        "Decisions are only ever appended; leaving a damaged one out would undo it silently.",
        "mend or remove that line of decisions.jsonl",
    ),
    "asset/catalog-unreadable": CodeInfo(
        "error",
        "The catalog of a library cannot be read",
        "It is damaged, or another version wrote it. The records beside it are the truth; it is only made from them.",
        "run mana assets ingest on the library again, which writes it anew",
    ),
    "asset/report-unreadable": CodeInfo(
        "error",
        "The report of a library cannot be read",
        "It is damaged, or another version wrote it. The packages and the decisions beside it are untouched.",
        "run mana assets ingest on the library again, which writes it anew",
    ),
    # Physics and acceptance.
    "asset/source-inertia-implausible": CodeInfo(
        "warning",
        "The mass, mass centre or inertia stated by the source cannot be true",
        "Placeholder values (one kilogram, unit inertia) make a body tumble or resist in ways its shape forbids.",
        "check the value in the source; the package holds one computed from the solid",
    ),
    "asset/source-friction-implausible": CodeInfo(
        "warning",
        "The friction or restitution stated by the source cannot be true",
        "Negative or enormous coefficients make contacts jitter or stick; restitution above one adds energy.",
        "check the value in the source; the package holds that of the material class",
    ),
    "asset/collision-fallback": CodeInfo(
        "warning",
        "The collision shape is coarser than wanted",
        "Every finer candidate failed or missed its tolerance.",
        "see the candidate table in the record; clean the mesh for a better fit",
    ),
    "asset/mixed-collider": CodeInfo(
        "info",
        "A collision shape covers parts of different materials",
        "An engine gives one shape one friction; where the other material touches it is another one.",
        "nothing, or model the parts so that they can have shapes of their own; the record lists the shares",
    ),
    "asset/render-collision-misaligned": CodeInfo(
        "error",
        "Collision and visible surface do not coincide",
        "Contacts would happen where nothing is seen.",
        "see the figures; clean the mesh and ingest again",
    ),
    "asset/unstable-settling": CodeInfo(
        "warning",
        "The object does not come to rest where it should",
        "It penetrates, drifts or keeps moving after being set down.",
        "check collision shape and mass centre in the record",
    ),
    "asset/reference-pose-topples": CodeInfo(
        "info",
        "The object does not stand in the pose it was authored in",
        "It tips over and comes to rest in another pose; that is physics, not a defect.",
        "nothing; place it in one of the stable poses of the record",
    ),
    "asset/no-stable-pose": CodeInfo(
        "info",
        "No trial came to rest in a pose that holds",
        "The object rolls or rocks on; scenes place it in its reference pose.",
        "nothing for balls and the like; else check collision shape and mass centre in the record",
    ),
    "asset/anchor-unverified": CodeInfo(
        "warning",
        "A surface or volume does not hold what is put there",
        "Geometry offers it, but in simulation probes fall off, through or out of it: collision shapes differ there.",
        "nothing if the anchor is not needed; else compare the collision picture, and clean the mesh there",
    ),
    "asset/no-grasp": CodeInfo(
        "info",
        "A parallel-jaw gripper cannot pick the object up",
        "It is fixed, too heavy or nowhere narrow enough for fingers 80 mm apart; `affordances` then holds no grasp.",
        "nothing if that is so; else check the unit and the mass in the record",
    ),
    "asset/grasp-not-held": CodeInfo(
        "info",
        "A grasp that geometry proposes slips in simulation",
        "It stays in the record as refuted and is left out of the USD.",
        "nothing while other grasps hold; else compare the collision picture with the object",
    ),
    "asset/package-invalid": CodeInfo(
        "error",
        "The written package fails validation",
        "Nothing is released that an outside validator rejects.",
        "this is a defect of Mana or an unusual input: please report it with the rule named",
    ),
    "asset/output-occupied": CodeInfo(
        "error",
        "Something else stands where the package should go",
        "Replacing it could destroy files that Mana did not make.",
        "choose another --out, or move the folder named away",
    ),
    "asset/internal-error": CodeInfo(
        "error",
        "A stage failed unexpectedly",
        "This is a defect of Mana, not of your file; the batch goes on without it.",
        "please report it with the traceback in report.json",
    ),
    **GATE_CODES,
    **GAP_CODES,
    **SCENE_CODES,
    **PLAN_CODES,
    **REPLAY_CODES,
}

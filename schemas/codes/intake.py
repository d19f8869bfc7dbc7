"""Diagnostic codes of reading: files, content, units and axes; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

INTAKE_CODES: dict[str, CodeInfo] = {
    # Intake: the file itself.
    "asset/format-unsupported": CodeInfo(
        "error",
        "The file type is not one Mana reads",
        "Only files of a format with a reader become assets; anything else is reported, not guessed at.",
        "convert the file to GLB or USD and ingest that",
    ),
    "asset/blender-missing": CodeInfo(
        "error",
        "Blender, which reads .blend files, is not set up",
        "A .blend holds modifiers and node graphs that only Blender evaluates. It is a large program of its own, which "
        "Mana installs when asked to.",
        "run `mana setup blender` once, then the same command again; or export the file as GLB or USD",
    ),
    "asset/blend-version": CodeInfo(
        "error",
        "The .blend file is of a version that Blender 5.0 does not read",
        "Files of later versions may hold blocks that an older Blender drops without a word; those before 2.48 differ.",
        "save it with Blender 5.0 or export it as GLB or USD",
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
        "make the named item smaller, or raise the limit if you trust the source; declared XML entities must go",
    ),
    "asset/source-missing": CodeInfo(
        "error",
        "The source is not there",
        "The file was removed or renamed after it was found, or it is a link to nothing; nothing can be known of it.",
        "put the file back, or mend the link, and run the same command again",
    ),
    "asset/source-unreadable": CodeInfo(
        "error",
        "The source is nothing that can be read",
        "A pipe, a device or a folder has no end or no content, so it is never opened; and a file that the operating "
        "system keeps from this user is unknown, not damaged.",
        "give a regular file that this user may read",
    ),
    "asset/synthesis-failed": CodeInfo(
        "error",
        "The generative model gave no usable mesh",
        "The program ended with an error, was late, or did not write exactly one model file that Mana reads.",
        "run the program by hand with its request, see docs/how-to/retopology.md",
    ),
    "asset/storage-failed": CodeInfo(
        "error",
        "A file of Mana's own could not be written or read",
        "The disk is full, or the output folder was removed, replaced or changed while the asset was made. That says "
        "nothing about the source, so it is not remembered: the next run makes the asset anew.",
        "see that the output folder is there, writable and has room, then run the same command again",
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
        "The source declares joints that are not carried over",
        "One rigid body would silently lock them. Of glTF no joints are read, of USD only those between rigid bodies.",
        "apply PhysicsRigidBodyAPI to the prims that move, or give the object as USD, URDF or MJCF",
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
    "asset/frame-unsettled": CodeInfo(
        "warning",
        "The pose or scale of the object does not settle",
        "Each look at the object in its new frame gives yet another one, so that none of them is sure.",
        "look at the pictures and state unit, axis or category, or report the file",
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
}

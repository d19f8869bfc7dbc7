"""Diagnostic codes of semantics, decisions of people, physics and acceptance; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

USE_CODES: dict[str, CodeInfo] = {
    # The folder of a library, and what leaves it.
    "asset/export-loss": CodeInfo(
        "warning",
        "The format of an export cannot hold something of the package",
        "MJCF, URDF and USDZ have no place for everything that a package states; a reader of the export has to know.",
        "use the package's own USD where the value matters",
    ),
    # Semantics.
    "asset/licence-missing": CodeInfo(
        "error",
        "No licence of an asset is on record",
        "Without a licence nobody but its author may pass an asset on, however it was found.",
        "find the licence, then `mana assets review LIBRARY ITEM --set license=CC-BY-4.0`, or ingest with --license",
    ),
    "asset/licence-unrecognised": CodeInfo(
        "error",
        "The licence on record is none whose terms are known here",
        "What it permits cannot be told from its name, so it is not passed on by default.",
        "state its SPDX id with its version, or read it and publish with --allow 'TEXT' as it is on record",
    ),
    "asset/licence-forbids-release": CodeInfo(
        "error",
        "The licence on record forbids to pass the asset on",
        "Research-only and internal terms, or rights that are reserved, do not allow redistribution.",
        "leave the asset out with --skip-refused, or record the licence that you were granted",
    ),
    "asset/licence-restricted": CodeInfo(
        "error",
        "The licence forbids commercial use or changed versions",
        "A package is a changed version of its source, and users of a release may be companies.",
        "publish with --allow nc or --allow nd where your permission covers it, or with --skip-refused",
    ),
    "asset/attribution-incomplete": CodeInfo(
        "warning",
        "The licence asks to name the author, and none is on record",
        "The release names the source file instead, which may not be enough.",
        "`mana assets review LIBRARY ITEM --set author=NAME`, then publish again",
    ),
    "asset/release-unaccepted": CodeInfo(
        "error",
        "An asset of a release awaits a person's decision",
        "Only accepted and repaired assets have passed all that Mana demands.",
        "decide with `mana assets review`, or publish with --allow review",
    ),
    "asset/release-altered": CodeInfo(
        "error",
        "A file of a release is not the one of its manifest",
        "It was changed, lost or added after the release was written.",
        "take the release again from where it came, or publish it anew",
    ),
    "asset/release-unreadable": CodeInfo(
        "error",
        "The manifest of a release cannot be read",
        "Without it nothing can be said of the files beside it.",
        "name a folder that `mana assets publish` wrote",
    ),
    "asset/library-package-damaged": CodeInfo(
        "error",
        "Files of a package are not those of its record",
        "A package is what its record says; a file that was changed, lost or cut off is not what was accepted.",
        "ingest its source into the library again, which makes the package anew",
    ),
    "asset/library-interrupted": CodeInfo(
        "warning",
        "A package was being replaced when its process ended",
        "The old package stands aside under a hidden name, and none is in its place.",
        "run `mana assets doctor`, which puts the old one back, or ingest the source again",
    ),
    "asset/library-leftover": CodeInfo(
        "info",
        "A file or folder of a process that was killed lies about",
        "Whatever Mana writes is written aside and moved into place when it is whole; this never was.",
        "run `mana assets doctor`, which removes it, or the same ingest again",
    ),
    "asset/library-owner-dangling": CodeInfo(
        "info",
        "The package that a source is noted to own is not there",
        "Somebody removed the package; the note would keep its name from other sources.",
        "run `mana assets doctor`, which removes the note",
    ),
    "asset/library-catalog-stale": CodeInfo(
        "warning",
        "The catalog does not list the packages that are there",
        "Listing and search read the catalog; packages were added, removed or changed beside it.",
        "run `mana assets doctor`, which writes it anew from the records",
    ),
    "asset/category-unknown": CodeInfo(
        "info",
        "Nothing tells what kind of thing the object is",
        "Names are silent, ambiguous or contradicted, and shape alone proves nothing; `unknown` beats a guess.",
        "say it with --category, or give the file or its folder a telling name",
    ),
    "asset/out-of-domain": CodeInfo(
        "warning",
        "The object is a vehicle, a character, a room or building, or cloth",
        "Mana prepares rigid and articulated things that robots handle, and what stands around them. Others keep a "
        "package, as one rigid body at one pose, but a person must say that this is wanted.",
        "say with --category or --role what it is used as, or leave it out",
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
        "nothing, or state a category of docs/reference/taxonomy.md",
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
        "run the command by hand on a surface, see docs/how-to/segmenter.md, or give it more time with "
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
    "asset/missing-joint": CodeInfo(
        "error",
        "There is no such joint to move",
        "The object is rigid, or no joint of that name moves on its own. Joints that follow another one move with it.",
        "name a joint that the finding lists, or draw a rigid object without --joints",
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
}

"""Codes of the static gate (`gate.static_gate`), one per rule, and of outside validators; part of `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo


def _error(title: str, why: str, help_: str) -> CodeInfo:
    return CodeInfo("error", title, why, help_)


GATE_CODES: dict[str, CodeInfo] = {
    # The file as a whole.
    "asset/gate-units": _error(
        "The package is not in metres, kilograms and z-up",
        "Simulators read the numbers as they stand; other units make every length and mass wrong.",
        "set metersPerUnit and kilogramsPerUnit to 1 and upAxis to Z, and convert the values",
    ),
    "asset/gate-default-prim": _error(
        "The package has no single, placeable component as its default prim",
        "Referencing the file would bring in nothing, or less than the asset.",
        "put everything under one Xform, make it the default prim with kind component",
    ),
    "asset/gate-missing-file": _error(
        "A file the package names is absent",
        "The surface loses its picture, or the asset a part, on every machine but, at best, one.",
        "put the file into the package and name it by a relative path",
    ),
    "asset/gate-outside-file": _error(
        "A file lies outside the package",
        "Whoever receives the folder does not receive that file.",
        "copy the file into the package and name it by a relative path",
    ),
    "asset/gate-physics-scene": _error(
        "The file brings its own gravity, or an impossible one",
        "Two scenes in one world compete; gravity that is zero, sideways or huge is rarely meant.",
        "leave the PhysicsScene to the world the asset is placed in",
    ),
    "asset/gate-time-samples": _error(
        "Values of the asset are animated",
        "Engines read physics at the default time only; an asset at rest has no motion of its own.",
        "author default values instead of time samples",
    ),
    "asset/gate-unknown-token": _error(
        "An attribute has a value that its schema does not know",
        "Each reader falls back to something else.",
        "use one of the tokens named",
    ),
    "asset/gate-extent": _error(
        "The visible size is impossible, unusual or differs from the stated one",
        "Scenes are laid out by the stated size; millimetres read as metres are 1000 times too large.",
        "correct the scale, or state the size the asset has",
    ),
    "asset/gate-category-size": _error(
        "The asset is too large or too small for its category",
        "A mug of three metres has the wrong unit or the wrong label.",
        "check the unit of the source and the category label",
    ),
    "asset/gate-origin": _error(
        "The asset frame is not at the bottom centre of the object",
        "Scenes place the origin on a support; the object would float, sink or stand beside the spot.",
        "leave the default prim untransformed and move the points",
    ),
    "asset/gate-label": _error(
        "A semantic label is missing, malformed or contradicted",
        "Whoever trains on the labels learns the wrong thing.",
        "make the class label, the Wikidata code, the metadata and the name agree",
    ),
    "asset/gate-metadata": _error(
        "The metadata state another mass or number of bodies than there are",
        "Catalogues and schedulers read the metadata, not the prims.",
        "write the metadata again from the prims",
    ),
    "asset/gate-record": _error(
        "The USD and its record.json state different things",
        "One of the two was changed after release, so neither can be trusted.",
        "ingest the source again, or carry the change over into both",
    ),
    "asset/gate-record-file": _error(
        "A file of the package is not the one its record.json was written for",
        "It was changed, replaced or removed after release, so no figure of the record holds for it.",
        "restore the file, or ingest the source again; a change that is meant needs a new record",
    ),
    "asset/gate-twin": _error(
        "The USD and its URDF twin state different mass properties",
        "The same object would move differently in two simulators; one of the files was changed after release.",
        "ingest the source again, or carry the change over into both",
    ),
    # Bodies.
    "asset/gate-transform": _error(
        "A transform is not finite or flattens its prim",
        "Positions, volumes and normals below it are undefined.",
        "correct the transform operations of the prim and its ancestors",
    ),
    "asset/gate-body-scale": _error(
        "A rigid body is scaled, sheared or mirrored",
        "Engines drop, bake or misread the scale of a body, each in its own way.",
        "apply the scale to the points and leave the body at scale 1",
    ),
    "asset/gate-nested-body": _error(
        "A rigid body lies below another one, or inside an instance",
        "Engines either tear nested bodies apart or weld them together; instances cannot hold bodies.",
        "put bodies side by side, or join the inner to the outer one",
    ),
    "asset/gate-body-flags": _error(
        "A body is disabled, kinematic, asleep, locked or weightless",
        "It hangs in the air or cannot be moved, and nothing on the screen says why.",
        "set rigidBodyEnabled true, kinematicEnabled and startsAsleep false, and leave gravity on",
    ),
    "asset/gate-velocity": _error(
        "A body starts with a velocity",
        "It leaves its place in the first step.",
        "remove physics:velocity and physics:angularVelocity",
    ),
    "asset/gate-mass": _error(
        "A body has no possible mass",
        "Engines then invent one (often 1 kg) or refuse the body.",
        "author physics:mass in kilograms on the body, with PhysicsMassAPI applied",
    ),
    "asset/gate-mass-twice": _error(
        "Mass is stated more than once",
        "The body's mass wins, so the other number is dead or the mistake.",
        "keep the mass on the body and remove masses and densities below it",
    ),
    "asset/gate-density": _error(
        "Mass and volume give a density no material has",
        "The object would push like lead or float like smoke.",
        "check the mass, the scale and the colliders against each other",
    ),
    "asset/gate-density-stated": _error(
        "The mass contradicts the density of the contact material",
        "Either the mass or the material is wrong; engines that compute mass from density differ from the others.",
        "make physics:mass and physics:density of the material agree",
    ),
    "asset/gate-inertia": _error(
        "The moments of inertia belong to no real body",
        "Engines become unstable or replace the tensor by their own.",
        "recompute the principal moments and axes from the solid",
    ),
    "asset/gate-inertia-reach": _error(
        "A moment of inertia is larger than that mass inside the shape can have",
        "Even with all mass at the far ends of the object it could not turn so slowly.",
        "recompute the inertia in kg m2 about the mass centre, or correct scale and mass",
    ),
    "asset/gate-inertia-scale": _error(
        "The inertia does not fit mass and shape",
        "The object would spin far too easily or hardly at all.",
        "recompute the inertia in kg m2 about the mass centre",
    ),
    "asset/gate-mass-centre-outside": _error(
        "The mass centre lies outside the colliders",
        "The object would topple or balance in ways its shape forbids.",
        "check the frame of physics:centerOfMass: it is the body's own",
    ),
    "asset/gate-mass-centre-far": _error(
        "The mass centre is far from the middle of the body",
        "Few things are that much heavier at one end; an origin left as mass centre looks like this.",
        "recompute physics:centerOfMass from the solid, in the frame of the body",
    ),
    # Colliders and contact.
    "asset/gate-no-collider": _error(
        "A moving body has no collider, or a disabled one",
        "It falls through everything.",
        "add collision shapes below the body and enable them",
    ),
    "asset/gate-collider-not-convex": _error(
        "A moving mesh collider is not convex",
        "Engines refuse concave moving meshes or let them fall through the floor.",
        "decompose the mesh and set physics:approximation to convexHull",
    ),
    "asset/gate-collider-shape": _error(
        "A collider has a shape engines do not take as it is",
        "Flat hulls abort MuJoCo, uneven spheres become something else, dents are filled up.",
        "give every hull volume, at most 64 points and no dents; scale round shapes evenly",
    ),
    "asset/gate-collider-displaced": _error(
        "Colliders and visible surface do not coincide",
        "Contacts would happen where nothing is seen.",
        "check place, scale and completeness of the colliders",
    ),
    "asset/gate-collider-incomplete": _error(
        "Part of the visible surface has no collider",
        "A hand reaches into what looks solid.",
        "add the missing collision shapes, or enable them",
    ),
    "asset/gate-collider-cavity": CodeInfo(
        "warning",
        "Colliders close an opening, or let out what lies in it",
        "A mug takes nothing, or loses what is put into it.",
        "decompose the collision shape around the opening, or ingest the source again",
    ),
    "asset/gate-collider-astray": _error(
        "A single collider stands away from the visible surface",
        "Things bump into empty space.",
        "check place and scale of the collider named",
    ),
    "asset/gate-collider-rendered": _error(
        "A collider is drawn on top of the visible surface",
        "Pictures and segmentation show hulls instead of the object.",
        "set purpose to guide on the collider",
    ),
    "asset/gate-collision-offset": _error(
        "Contact and rest offsets are out of order",
        "Objects float above what they stand on or sink into it; engines refuse a rest offset above the contact one.",
        "remove the offsets or keep 0 <= restOffset <= contactOffset, both small",
    ),
    "asset/gate-contact-material": _error(
        "A collider has no contact material",
        "Friction is then whatever the engine defaults to.",
        "bind a Material with PhysicsMaterialAPI for purpose physics to every collider",
    ),
    "asset/gate-friction": _error(
        "Friction is impossible, missing or static below dynamic",
        "Static friction below dynamic, or below zero, gives jitter or is ignored.",
        "set static >= dynamic >= 0 friction, for dry pairs below 1.5",
    ),
    "asset/gate-restitution": _error(
        "Restitution lies outside 0 to 1",
        "Above 1 every bounce adds energy; below 0 is undefined.",
        "set physics:restitution between 0 and 1",
    ),
    "asset/gate-dangling-target": _error(
        "A physics relationship names a prim that does not exist",
        "The filter, group or scene that was meant has no effect.",
        "name an existing prim or remove the target",
    ),
    # Joints.
    "asset/gate-joint-bodies": _error(
        "A joint does not join two different bodies",
        "Engines ignore it, weld something to the world, or refuse the file.",
        "name one existing body in body0 and another one in body1",
    ),
    "asset/gate-joint-axis": _error(
        "A joint frame is no frame",
        "An unknown axis or a quaternion of another length than 1 is read differently by every engine.",
        "use axis X, Y or Z, finite positions and unit quaternions",
    ),
    "asset/gate-joint-limits": _error(
        "Joint limits are inverted or missing",
        "The joint locks, or moves freely, depending on the engine.",
        "state lower <= upper, in degrees for hinges and metres for slides",
    ),
    "asset/gate-joint-range": _error(
        "The range of a joint is none a mechanism has",
        "Radians read as degrees make a door that moves by a hair, millimetres as metres a drawer that flies away.",
        "check the unit: USD wants degrees for hinges and stage units for slides",
    ),
    "asset/gate-joint-frames": _error(
        "The two sides of a joint disagree in the rest pose",
        "The solver snaps the bodies together in the first step, with any force it takes.",
        "recompute localPos and localRot of one side from the other and the poses of the bodies",
    ),
    "asset/gate-joint-rest": _error(
        "A joint starts outside its limits",
        "The solver throws the body inside at once.",
        "shift the limits, or author the bodies in a pose within them",
    ),
    "asset/gate-joint-anchor": _error(
        "A hinge lies far away from its bodies",
        "The link would swing round a point in the air.",
        "check localPos0 and localPos1: they are in the frames of the bodies",
    ),
    "asset/gate-joint-flags": _error(
        "A joint is disabled, breaks or has negative friction",
        "The mechanism falls apart or gains energy.",
        "enable the joint, leave break force and torque infinite, keep damping and friction positive",
    ),
    "asset/gate-drive": _error(
        "A drive has impossible gains or nothing to drive",
        "Negative gains push away from the target; infinite ones end the simulation in NaN.",
        "keep stiffness, damping and maxForce finite and >= 0, and match the drive to the joint type",
    ),
    "asset/gate-articulation": _error(
        "The links form no tree",
        "Reduced-coordinate solvers refuse loops and nested roots; a link joined to nothing drops off.",
        "apply one articulation root, join every link, exclude loop closers from the articulation",
    ),
    "asset/gate-links-overlap": _error(
        "Links occupy the same space at rest",
        "They burst apart in the first step, or never move.",
        "move the links apart, shrink their colliders, or filter pairs that are meant to overlap",
    ),
    "asset/gate-joint-motion": _error(
        "A joint drives one link through the other",
        "The axis, the place of the joint or a limit is wrong: the drawer leaves through the side of its cabinet.",
        "check physics:axis, localPos, localRot and the limits; look at the asset at both limits",
    ),
    # Looks.
    "asset/gate-not-visible": _error(
        "Nothing, or not all, of the asset can be seen",
        "Cameras see something else than contacts feel.",
        "give every body a visible mesh with purpose default and visibility inherited",
    ),
    "asset/gate-mesh-topology": _error(
        "Faces or attributes of a mesh do not fit its points",
        "Renderers drop the mesh, show noise or read foreign memory.",
        "export the mesh again",
    ),
    "asset/gate-mesh-values": _error(
        "A mesh holds NaN or infinity",
        "One such value poisons bounds, shading and contacts.",
        "find and fix the values in the array named",
    ),
    "asset/gate-mesh-extent": _error(
        "The stated bounds of a mesh are not those of its points",
        "Viewers cull and frame by the stated bounds, so that the mesh vanishes.",
        "recompute the extent from the points",
    ),
    "asset/gate-normals": _error(
        "Normals point inwards or do not have length 1",
        "The surface is lit from the wrong side.",
        "recompute the normals from the faces",
    ),
    "asset/gate-inverted-mesh": _error(
        "A visible surface is inside out",
        "Back-face culling makes it vanish; rays and volumes change sign.",
        "reverse the winding of the faces, or the orientation of the mesh",
    ),
    "asset/gate-open-mesh": _error(
        "A visible surface has holes it was not released with",
        "One looks through the object.",
        "restore the faces, or ingest the source again",
    ),
    "asset/gate-material-binding": _error(
        "A material binding leads to no material",
        "The surface is drawn grey, or the contact uses defaults.",
        "bind an existing Material prim",
    ),
    "asset/gate-shader-network": _error(
        "A shader network is incomplete",
        "The material is drawn black or not at all.",
        "connect the surface output, name every shader's id, and connect only to what exists",
    ),
    "asset/gate-shader-value": _error(
        "A shader value is out of range",
        "Outside its range a shader is undefined: surfaces glow, turn black or reflect more light than they get.",
        "clamp the value to the range named",
    ),
    "asset/gate-texture-reader": _error(
        "A texture is read in the wrong colour space or scale",
        "Roughness read as sRGB is off by half; normals that are not unpacked light everything from one side.",
        "read colours as sRGB and everything else raw; unpack normal maps with scale 2 and bias -1",
    ),
    "asset/gate-texture-coordinates": _error(
        "A textured mesh lacks texture coordinates",
        "The picture shrinks to a single colour.",
        "author the primvar the material reads",
    ),
    "asset/gate-texture-image": _error(
        "A texture file is no readable picture",
        "The surface loses its picture.",
        "replace the file named",
    ),
    "asset/gate-nonfinite-value": _error(
        "An engine parameter is not a number",
        "NaN spreads through a solver in one step.",
        "remove the attribute or give it a number",
    ),
    # What outside validators say, as `mana assets validate` reports it.
    "asset/simready-rule": _error(
        "SimReady Foundation refuses something",
        "Isaac Sim and its kin take packages that pass its profile; a file that claims nothing may ignore it.",
        "see the requirement named in the SimReady Foundation documentation",
    ),
    "asset/usd-rule": _error(
        "OpenUSD's own validators refuse something",
        "The file breaks a rule of a USD schema, so readers will disagree about it.",
        "see the validator named in the OpenUSD documentation",
    ),
}

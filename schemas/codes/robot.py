"""Diagnostic codes of robot descriptions (URDF, MJCF); part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

ROBOT_CODES: dict[str, CodeInfo] = {
    # The description as files.
    "robot/unreadable": CodeInfo(
        "error",
        "The description is too large or no well-formed XML",
        "A reader that guesses past damage invents links and joints.",
        "correct the XML at the line named, or copy the file again",
    ),
    "robot/xml-declarations": CodeInfo(
        "error",
        "The XML declares entities or names a document type elsewhere",
        "Entities can grow without bound, or read any file on the machine; robot descriptions need none.",
        "remove the <!DOCTYPE ...> and write the values out",
    ),
    "robot/unknown-root": CodeInfo(
        "error",
        "The outermost element is not that of the format",
        "The file is of another format than its name suggests.",
        "give a URDF file (<robot>) or an MJCF file (<mujoco>); export SDF models as URDF",
    ),
    "robot/xacro": CodeInfo(
        "error",
        "The file is a xacro template that has not been expanded",
        "Its macros decide which links and joints there are.",
        "run `xacro model.urdf.xacro > model.urdf` and give the result",
    ),
    "robot/sdf": CodeInfo(
        "error",
        "The file is an SDF model",
        "Its frames, includes and plugins follow rules of Gazebo's own.",
        "run `gz sdf -p model.sdf > model.urdf` or the sdformat_urdf parser, and give the URDF; or export MJCF or USD",
    ),
    "robot/path-escape": CodeInfo(
        "error",
        "A reference leads out of the folder of the description",
        "Following it could read any file on the machine; it is never opened.",
        "copy the file into the folder, or give the folder above both as the root",
    ),
    "robot/missing-file": CodeInfo(
        "error",
        "The description or a file that it includes is absent or cannot be opened",
        "What it would define is not known.",
        "put the file where the message says",
    ),
    "robot/repeated-include": CodeInfo(
        "error",
        "A file is included a second time, or includes itself",
        "The reading would not end, or define everything twice; MuJoCo refuses it too.",
        "include each file once",
    ),
    "robot/missing-mesh": CodeInfo(
        "error",
        "A mesh file is absent",
        "What has no shape cannot be drawn, weighed or kept clear of.",
        "put the mesh files where the description says, or correct the name",
    ),
    # The description as a tree.
    "robot/missing-name": CodeInfo(
        "error",
        "An element that others refer to has no name, or a reference names nothing",
        "Links and joints are connected by name.",
        "add the attribute that the message names",
    ),
    "robot/duplicate-name": CodeInfo(
        "error",
        "Two elements of one kind have the same name",
        "A reference to the name could mean either.",
        "rename one of the two",
    ),
    "robot/no-links": CodeInfo(
        "error",
        "The description has no link",
        "There is no body.",
        "check that the file was exported whole",
    ),
    "robot/missing-link": CodeInfo(
        "error",
        "A joint names a link that is not there",
        "The joint connects nothing.",
        "add the link, or correct the name in <parent> or <child>",
    ),
    "robot/two-parents": CodeInfo(
        "error",
        "A link is the child of two joints",
        "The links form a loop, which a URDF cannot express; engines drop one of the joints without a word.",
        "leave out one joint, and close the loop in the simulator",
    ),
    "robot/link-cycle": CodeInfo(
        "error",
        "Links are each other's descendants",
        "No link of the cycle has a place.",
        "correct <parent> and <child> of the joints named",
    ),
    "robot/several-roots": CodeInfo(
        "error",
        "Several links have no parent",
        "The file describes several unconnected bodies; engines keep one of them, or crash.",
        "connect the links named by joints, or write one file for each body",
    ),
    "robot/empty-link": CodeInfo(
        "error",
        "A link that moves has no shape",
        "It can be neither drawn nor weighed; engines refuse a massless body between two joints.",
        "give the link a shape, or join its neighbours by one joint",
    ),
    "robot/base-joint": CodeInfo(
        "info",
        "A joint moves nothing within the object",
        "It holds the whole object in the world, or follows a joint that does not move.",
        "nothing; the joint can be added where the object is placed",
    ),
    "robot/closing-joint": CodeInfo(
        "warning",
        "A joint closes a loop",
        "Articulations are trees: engines take the joint as a constraint, and a URDF cannot hold it.",
        "use the USD where the loop matters",
    ),
    "robot/too-many-links": CodeInfo(
        "error",
        "More links move than engines take in one articulation",
        "The file is a scene or a chain of particles, not one object.",
        "give a file for each object",
    ),
    # The description as numbers.
    "robot/invalid-number": CodeInfo(
        "error",
        "An attribute is not the right count of finite numbers",
        "A number that is guessed at puts a link in a wrong place.",
        "write the numbers that the message asks for, with blanks between them",
    ),
    "robot/zero-axis": CodeInfo(
        "error",
        "The axis of a joint has no direction",
        "The joint could move in any direction.",
        "give the direction in which the joint turns or slides",
    ),
    "robot/axis-not-unit": CodeInfo(
        "warning",
        "The axis of a joint is not of length 1",
        "Engines that take it as it stands move a slide by that many times too much.",
        "nothing; the direction was used. Write a unit vector",
    ),
    "robot/invalid-orientation": CodeInfo(
        "error",
        "An orientation is given twice, or has no direction",
        "The element could be turned in any way.",
        "keep one of quat, axisangle, euler, xyaxes, zaxis, and no vector of length zero",
    ),
    "robot/invalid-value": CodeInfo(
        "error",
        "An attribute has a value that the format does not know",
        "A value that is guessed at changes the model.",
        "use one of the values that the message lists",
    ),
    "robot/unknown-class": CodeInfo(
        "error",
        "An element names a class of defaults that is not there",
        "The attributes of the class are not known.",
        "add the class to <default>, or correct its name",
    ),
    "robot/unknown-reference": CodeInfo(
        "error",
        "An element names a mesh, material or joint that is not there",
        "What it refers to is not known.",
        "add the element, or correct the name",
    ),
    "robot/mimic-cycle": CodeInfo(
        "error",
        "Joints mimic each other in a circle",
        "None of them has a position of its own.",
        "let one of the joints named move freely",
    ),
    "robot/invalid-size": CodeInfo(
        "error",
        "A shape has no size, or a size that is not positive",
        "Such a shape has no volume; engines draw it as something else.",
        "give positive sizes",
    ),
    "robot/unsupported-shape": CodeInfo(
        "error",
        "A shape is of a kind that Mana does not read",
        "To leave it out would leave something that collides uncovered.",
        "replace it by a mesh or one of box, sphere, cylinder, capsule, ellipsoid, plane",
    ),
    "robot/global-coordinates": CodeInfo(
        "error",
        "The model states positions in the frame of the world",
        "MuJoCo 2.3.4 dropped this setting; joint anchors and orientations would be read in the wrong frame.",
        "load the model in MuJoCo 2.3.3 or older and save it again (mj_saveLastXML)",
    ),
    "robot/not-expressible": CodeInfo(
        "error",
        "The other format has no element for a part of the model",
        "To leave it out would write another mechanism.",
        "write the other format, or remove the element named",
    ),
    # Statements that are kept and doubted.
    "robot/invalid-mass": CodeInfo(
        "warning",
        "A stated mass is zero or negative",
        "PyBullet takes a mass of zero as fixed to the world; a body that moves needs mass.",
        "state the mass, or remove <inertial>",
    ),
    "robot/invalid-inertia": CodeInfo(
        "warning",
        "No body has the stated inertia tensor",
        "Its moments are not positive or break the triangle inequality; engines replace it without a word.",
        "compute the tensor about the mass centre again",
    ),
    "robot/missing-attribute": CodeInfo(
        "warning",
        "An attribute is absent that the format asks for",
        "Some engines refuse the file, others take a value of their own.",
        "write the attribute that the message names",
    ),
    "robot/missing-inertial": CodeInfo(
        "info",
        "A link with shapes states no mass",
        "URDF has no rule for it: engines take 1 kg, or fix the link to the world.",
        "state <inertial>",
    ),
    "robot/missing-limit": CodeInfo(
        "warning",
        "A revolute or prismatic joint states no limits",
        "URDF asks for them; engines take the joint as free or as locked at zero.",
        "state <limit>, or make the joint continuous",
    ),
    "robot/reversed-limits": CodeInfo(
        "warning",
        "The lower limit of a joint is not below the upper one",
        "PyBullet and MuJoCo take such a joint as free, ROS as locked or wrong.",
        "swap the limits, or make the joint fixed or continuous",
    ),
    "robot/unread-element": CodeInfo(
        "info",
        "Elements were not understood and are kept as text",
        "They change nothing that Mana computes; simulators may use them.",
        "see the lines named",
    ),
}

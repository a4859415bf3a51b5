"""Rows of the table of codes: files of robots.

An example is the file of the robot, since a scene only names it: what follows `# robot.urdf: ` is run by a test.
"""

from scenecc.diagnostics.codes.row import Code


def _urdf(content: str) -> str:
    """The command that meets a URDF of some content."""
    return f'$ scenecc validate scene.yaml   # robot.urdf: <robot name="r">{content}</robot>'


ROWS: tuple[Code, ...] = (
    Code(
        "SC450",
        "error",
        "the robot's file is no XML",
        "A URDF, an SRDF and an MJCF are well-formed XML in UTF-8. The place is where the parser gave up, which may be "
        "after the mistake.",
        _urdf('<link name="base">'),
        "Close every element, quote every attribute's value, and write `&lt;` and `&amp;` for `<` and `&`. A xacro is "
        "made a URDF by `xacro robot.urdf.xacro > robot.urdf`.",
    ),
    Code(
        "SC451",
        "error",
        "document type in a robot's file",
        "A document type may declare entities, of which ten lines can unfold to more text than any memory holds, and "
        "may name files to be read. None is read, whatever it says.",
        '$ scenecc validate scene.yaml   # robot.urdf: <!DOCTYPE robot [<!ENTITY a "b">]><robot name="&a;"/>',
        "Take the `<!DOCTYPE …>` away, and write out the entities that it declares.",
    ),
    Code(
        "SC452",
        "error",
        "the robot's file is too large",
        "A file of a robot has at most 16 MiB of text, 100 elements inside one another, 100 000 elements and 200 000 "
        "attributes, a URDF 4096 links and as many joints: a hundred times what the largest robots have.",
        "$ head -c 17000000 /dev/zero | tr '\\0' ' ' > robot.urdf; scenecc validate scene.yaml",
        "Take out what the robot does not need; a mesh stands in a file of its own.",
    ),
    Code(
        "SC453",
        "error",
        "another kind of file than a robot's",
        "A URDF and an SRDF are a `<robot>`, an MJCF is a `<mujoco>`.",
        '$ scenecc validate scene.yaml   # robot.urdf: <mujoco model="hand"/>',
        "Give an MJCF with `mjcf:` and a URDF with `urdf:`. An SDF is not read.",
    ),
    Code(
        "SC454",
        "warning",
        "element or attribute of a URDF that is not known",
        "It is not read, so that what it says does not hold: perhaps it is misspelt, or it is meant for another "
        "program. It is told once of each kind. What is meant for Gazebo and for controllers (`<gazebo>`, "
        "`<transmission>`, `<safety_controller>`, `<calibration>`) is known and left out without a word.",
        _urdf('<link name="base"><inertials/></link>'),
        "Mend the spelling, or take it away. A xacro is made a URDF by `xacro robot.urdf.xacro > robot.urdf`.",
    ),
    Code(
        "SC455",
        "error",
        "element or attribute of a URDF that is missing",
        "Without it the robot cannot be built.",
        _urdf('<link name="base"/><link name="arm"/><joint name="turn" type="fixed"><parent link="base"/></joint>'),
        "Write it.",
    ),
    Code(
        "SC456",
        "error",
        "number in a robot's file that is none",
        "Numbers are finite, parted by blanks, as many as are wanted, and within the engine's single precision. "
        "SAPIEN's loader takes what it can read of them: of `1,2,3` the 1, for all three.",
        _urdf('<link name="base"><collision><geometry><box size="1, 1, 1"/></geometry></collision></link>'),
        "Write plain numbers with blanks between them. Angles are in radians, lengths in metres.",
    ),
    Code(
        "SC460",
        "error",
        "the same name twice in a robot's file",
        "Links are named once, and so are joints and the materials at the top of the file: joints name links, and "
        "scenes name both.",
        _urdf('<link name="base"/><link name="base"/>'),
        "Give each a name of its own.",
    ),
    Code(
        "SC461",
        "error",
        "joint of a link that does not exist",
        "Its parent and its child are two links of the same file.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="turn" type="fixed"><parent link="bas"/>'
            '<child link="arm"/></joint>'
        ),
        "Write the name of a `<link>`, in the letter case that it has.",
    ),
    Code(
        "SC462",
        "error",
        "link with two parents",
        "Links form a tree: a link is the child of one joint at most.",
        _urdf(
            '<link name="a"/><link name="b"/><joint name="one" type="fixed"><parent link="a"/><child link="b"/></joint>'
            '<joint name="two" type="fixed"><parent link="a"/><child link="b"/></joint>'
        ),
        "Take one of the joints away. A mechanism with a loop is cut at one place, and closed there by a constraint of "
        "the scene.",
    ),
    Code(
        "SC463",
        "error",
        "links that are not one tree",
        "There is one link that is the child of no joint, the root, and all others hang on it.",
        _urdf('<link name="base"/><link name="arm"/>'),
        "Connect the links with joints. What is to move freely hangs on the root by a floating joint, and is then a "
        "robot or a body of its own; or it stands in a file of its own.",
    ),
    Code(
        "SC464",
        "error",
        "joint of a type that is not supported",
        "A joint is fixed, revolute, continuous or prismatic. A floating joint makes what hangs on it a robot of its "
        "own, so that it hangs on the root itself. SAPIEN has no planar joint.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="slide" type="planar"><parent link="base"/>'
            '<child link="arm"/></joint>'
        ),
        "For a planar joint write two prismatic joints and a revolute one, with links of little mass between them.",
    ),
    Code(
        "SC465",
        "error",
        "joint without limits, or with the lower above the upper",
        "A revolute and a prismatic joint have both limits, which may be `-inf` and `inf`. SAPIEN's loader fails "
        "without them.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="turn" type="revolute"><parent link="base"/>'
            '<child link="arm"/><limit lower="1" upper="-1"/></joint>'
        ),
        "Write `<limit lower=… upper=…/>`, in radians or metres. A joint that turns without end is `continuous`.",
    ),
    Code(
        "SC466",
        "error",
        "size of a robot's shape that is not above 0",
        "Radii, lengths and sides are above 0, no scale is 0, and friction and damping are not below it. SAPIEN builds "
        "bodies of a milligram from such sizes.",
        _urdf('<link name="base"><collision><geometry><sphere radius="0"/></geometry></collision></link>'),
        "Mend the number. A plate without thickness is a thin box.",
    ),
    Code(
        "SC467",
        "error",
        "mass or inertia that SAPIEN refuses",
        "A mass is not below 0, and each principal moment of inertia is above it. The principal moments are the "
        "eigenvalues of the matrix that is written, so that large products of inertia (`ixy`, `ixz`, `iyz`) make one "
        "negative.",
        _urdf(
            '<link name="base"><inertial><mass value="1"/>'
            '<inertia ixx="1" iyy="1" izz="1" ixy="2" ixz="0" iyz="0"/></inertial></link>'
        ),
        "Compute the inertia anew, or take the `<inertial>` away: mass and inertia then follow from the shapes.",
    ),
    Code(
        "SC468",
        "warning",
        "inertia that no body has",
        "None of the three principal moments of inertia of a body is above the sum of the two others. The engine takes "
        "such an inertia all the same, and many files of robots have one.",
        _urdf(
            '<link name="base"><inertial><mass value="1"/>'
            '<inertia ixx="1" iyy="1" izz="5" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        ),
        "Compute the inertia anew, about the centre of mass and in kg·m².",
    ),
    Code(
        "SC469",
        "warning",
        "joint's axis without length",
        "SAPIEN takes x for it without a word.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="turn" type="continuous"><parent link="base"/>'
            '<child link="arm"/><axis xyz="0 0 0"/></joint>'
        ),
        "Write the axis that is meant.",
    ),
    Code(
        "SC470",
        "warning",
        "camera in a URDF",
        "It is not built: what it sees and how is the scene's to say.",
        _urdf('<link name="base"/><sensor name="eye"><parent link="base"/><camera/></sensor>'),
        "Declare it under `cameras`, with `mount: ROBOT/LINK`.",
    ),
    Code(
        "SC471",
        "error",
        "pair of an SRDF that is none",
        "A `<disable_collisions>` names two different links of the robot.",
        _urdf('<link name="base"/>')
        + '   # robot.srdf: <robot name="r"><disable_collisions link1="base" link2="arm" reason="Default"/></robot>',
        "Mend the names, or take the pair away. `srdf: none` in the scene leaves the whole file out.",
    ),
    Code(
        "SC472",
        "error",
        "joint that follows what it cannot",
        "`<mimic>` names another joint of the same robot that moves, not by way of other joints the joint itself, and "
        "its multiplier is not 0.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="turn" type="continuous"><parent link="base"/>'
            '<child link="arm"/><mimic joint="other"/></joint>'
        ),
        "Name a joint that moves by itself.",
    ),
    Code(
        "SC473",
        "error",
        "more pairs in an SRDF than there are bits",
        "Each pair of links that is not to collide takes a bit of a collision integer, and SAPIEN's loader has 31. "
        "Pairs of parent and child take none.",
        "$ scenecc validate scene.yaml   # robot.srdf with 32 pairs of links",
        "Leave out pairs that never meet, or say `disable_self_collisions: true` in the scene.",
    ),
    Code(
        "SC474",
        "warning",
        "pair of an SRDF that is not heeded",
        "SAPIEN's loader heeds the pairs whose reason is `Default`. Those of neighbours (`Adjacent`) and of links that "
        "cannot meet (`Never`) make no difference; a pair with another reason or none will collide.",
        _urdf(
            '<link name="base"/><link name="arm"/><joint name="turn" type="fixed"><parent link="base"/>'
            '<child link="arm"/></joint>'
        )
        + '   # robot.srdf: <robot name="r"><disable_collisions link1="base" link2="arm" reason="User"/></robot>',
        'Write `reason="Default"` where the pair is not to collide.',
    ),
    Code(
        "SC475",
        "warning",
        "mass without inertia, or inertia without mass",
        "SAPIEN's loader leaves an `<inertial>` out whose mass or whose whole inertia is 0: the link then has the mass "
        "that its shapes and their densities give.",
        _urdf(
            '<link name="base"><inertial><mass value="1"/>'
            '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        ),
        "Write both, or take the `<inertial>` away.",
    ),
    Code(
        "SC476",
        "warning",
        "two materials of one name",
        "Of materials of one name the first that is met counts everywhere, those at the top of the file before those "
        "of links. So does SAPIEN's loader.",
        _urdf(
            '<link name="base">'
            '<visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="1 0 0 1"/></material>'
            '</visual><visual><geometry><sphere radius="2"/></geometry><material name="m"><color rgba="0 1 0 1"/>'
            "</material></visual></link>"
        ),
        "Give each a name of its own.",
    ),
    Code(
        "SC477",
        "error",
        "more links than the engine counts",
        "PhysX numbers the links of an articulation on the CPU by a byte: one of 257 links has no degrees of freedom.",
        "$ scenecc validate scene.yaml   # robot.urdf with 256 links",
        "Join links that are fixed to one another.",
    ),
    Code(
        "SC487",
        "warning",
        "actuator's limit below 0",
        "An `effort` or a `velocity` of a joint is negative, as some exporters write where they know of none. None is "
        "taken then, as of 0.",
        _urdf(
            '<link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
            '<limit lower="0" upper="1" effort="-1"/></joint>'
        ),
        "Write what the actuator can do, or leave it out.",
    ),
)

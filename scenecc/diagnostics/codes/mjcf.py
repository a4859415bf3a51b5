"""Rows of the table of codes: MJCF files.

An example is the file of the robot, since a scene only names it: what follows `# robot.xml: ` is run by a test.
"""

from scenecc.diagnostics.codes.row import Code


def _mjcf(world: str, rest: str = "") -> str:
    """The command that meets an MJCF of some content."""
    return f"$ scenecc validate scene.yaml   # robot.xml: <mujoco>{rest}<worldbody>{world}</worldbody></mujoco>"


ROWS: tuple[Code, ...] = (
    Code(
        "SC480",
        "error",
        "an MJCF without anything that is built",
        "The file's world holds neither a body nor a geom that can be built, or it has no `<worldbody>`. Where "
        "something of it is left out, the message says what.",
        _mjcf('<light pos="0 0 3"/>'),
        "Name the file that holds the robot: a `scene.xml` often only includes it.",
    ),
    Code(
        "SC481",
        "error",
        "a wrong value in an MJCF",
        "An attribute is none of its words, has too few or too many numbers, or one that means nothing: a size that is "
        "not above 0, an axis of no length, a range from high to low. MuJoCo refuses these, too; SAPIEN builds what is "
        "left.",
        _mjcf('<geom type="box" size="0.1 0.1"/>'),
        "Write what the message asks for.",
    ),
    Code(
        "SC482",
        "error",
        "a name that an MJCF does not define",
        "A default class, a material, a mesh or a texture is named that neither the file has nor one that it includes.",
        _mjcf('<geom size="0.1" class="wheel"/>'),
        "Mend the name, or include the file that defines it.",
    ),
    Code(
        "SC483",
        "error",
        "an MJCF asks for what cannot be built",
        "Ball joints, free bodies inside others, height fields, signed distance fields, meshes without a file, and "
        "elements of which MuJoCo makes bodies (`frame`, `replicate`, `composite`, …): without "
        "them, what is built would be another robot.",
        _mjcf('<body><joint type="ball"/><geom size="0.1"/></body>'),
        "Replace a ball joint by three hinges. What MuJoCo unfolds, it can write out: `mujoco.mj_saveLastXML`.",
    ),
    Code(
        "SC484",
        "warning",
        "part of an MJCF is left out",
        "SAPIEN knows no actuators, sensors, sites or tendons, and what the scene says itself (cameras, lights, "
        "gravity) is not taken from a robot's file. Of each kind the first is told. The page on robots lists what "
        "is read.",
        _mjcf('<geom size="0.1" mass="2"/>'),
        "Say it in the scene, where the hint names a key; else take it out of the file, or leave it.",
    ),
    Code(
        "SC485",
        "note",
        "an MJCF means something else than ManiSkill's loader reads",
        "ManiSkill's loader reads some of MJCF otherwise than MuJoCo defines it: Euler angles about y turn the other "
        "way, a joint without an axis turns about x. Here the file means what MJCF means.",
        _mjcf('<body euler="0 30 0"><joint axis="0 1 0"/><geom size="0.1"/></body>'),
        "Nothing need be done, unless a policy was trained on what ManiSkill builds.",
    ),
    Code(
        "SC486",
        "error",
        "a name twice in an MJCF",
        "Two bodies, geoms, joints, sites, default classes or assets have one name, or a file is included twice.",
        _mjcf('<body name="a"><joint axis="0 0 1"/><geom size="0.1"/><body name="a"><geom size="0.1"/></body></body>'),
        "Give one of them another name.",
    ),
)

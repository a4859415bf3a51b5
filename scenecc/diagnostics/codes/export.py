"""Rows of the table of codes: files of other programs."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        code="SC730",
        severity="warning",
        title="something that an MJCF has not",
        cause="MuJoCo has nothing that would hold it, so the model that was written is without it.",
        example="$ scenecc emit scenes/knobs.yaml --to mjcf    # with a `max_linear_velocity`, among others",
        cure="Nothing has to be done where it does not matter there; otherwise set in MuJoCo what is meant.",
    ),
    Code(
        code="SC731",
        severity="warning",
        title="something that an MJCF has otherwise",
        cause="MuJoCo has something like it that is not the same, and the model that was written has that.",
        example="$ scenecc emit scenes/knobs.yaml --to mjcf    # a triangle mesh, which collides as its convex hull",
        cure="Nothing has to be done where the difference does not matter; a mesh can be cut into convex parts.",
    ),
    Code(
        code="SC740",
        severity="warning",
        title="something that a URDF has not",
        cause="URDF has nothing that would hold it, so the robot that was written is without it.",
        example="$ scenecc emit scenes/robot_arm.yaml --to urdf --entity arm    # whose joints have drives",
        cure="Nothing has to be done where it does not matter; otherwise say it where the robot is loaded.",
    ),
    Code(
        code="SC741",
        severity="warning",
        title="something that a URDF has otherwise",
        cause="URDF has something like it that is not the same, and the robot that was written has that.",
        example="$ scenecc emit scenes/robot_arm.yaml --to urdf --entity arm    # whose joints have a friction",
        cure="Nothing has to be done where the difference does not matter.",
    ),
)

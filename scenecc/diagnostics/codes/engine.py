"""Rows of the table of codes: the engine and the machine."""

from scenecc.diagnostics.codes.row import Code

ROWS: tuple[Code, ...] = (
    Code(
        "SC801",
        "error",
        "the engine cannot make a collision shape",
        "PhysX could not read or cook the mesh. SAPIEN's own builder leaves such a shape out without a word, and "
        "the body then weighs a milligram and falls through everything.",
        "$ scenecc build scene.yaml    # where a mesh is replaced by something unreadable after the check",
        "Look at the file that the shape names: it must be a mesh with at least one face and with a volume.",
    ),
    Code(
        "SC802",
        "error",
        "the engine holds something else than the plan",
        "After building, scenecc reads back what the engine holds and compares it with what the scene asked for. "
        "Something differs: another part of the process changed the scene or the engine, or scenecc has a fault.",
        "$ scenecc build scene.yaml    # in a process that patches the engine",
        "Build in a process in which nothing else touches SAPIEN. If it stays, report it with the scene file.",
    ),
    Code(
        "SC803",
        "error",
        "no render device",
        "Visuals were asked for, and SAPIEN finds no device that renders: it needs a Vulkan driver, physics does not.",
        "$ python -c 'import scenecc; scenecc.load_scene(\"scene.yaml\", render=True)'    # without a Vulkan driver",
        "Install a Vulkan driver (Mesa's lavapipe, from 24.3 on, renders on the CPU), or build with `render=False`, "
        "or leave `render` out: visuals are then built where a device exists.",
    ),
    Code(
        "SC804",
        "error",
        "no GPU simulation",
        "Scenes on the GPU need PhysX's GPU library and a CUDA driver. SAPIEN would download the library on first use; "
        "scenecc downloads nothing, and this version builds on the CPU only.",
        "$ scenecc build scene.yaml --backend cuda",
        "Use the cpu backend.",
    ),
    Code(
        "SC805",
        "error",
        "SAPIEN or ManiSkill cannot be used",
        "Building needs the package `sapien`, 3.0 from 3.0.3 on: others build other things from the same calls. "
        "`scenecc.maniskill` needs the extra `maniskill` and PyTorch.",
        "$ scenecc build scene.yaml    # in an environment without SAPIEN",
        "`pip install 'sapien>=3.0.3,<3.1'`, or `pip install torch 'scenecc[maniskill]'`. Validation, plans and "
        "emitted scripts need neither.",
    ),
    Code(
        "SC806",
        "error",
        "convex decomposition failed",
        "`decomposition: coacd` runs CoACD on the mesh. It is not installed, it could not cut this mesh, or the cache "
        "folder for its results cannot be written.",
        "$ scenecc build scene.yaml    # with `decomposition: coacd`, without the package coacd",
        "`pip install 'scenecc[convex]'`; for a mesh that CoACD refuses, close its holes or cut it by hand and use "
        "`decomposition: none`.",
    ),
    Code(
        "SC807",
        "error",
        "the renderer cannot make a visual",
        "The renderer could not read the mesh or the image that a visual, a light or the surroundings name, or the "
        "render device cannot make what a camera asks for: one that traces rays, where the device cannot.",
        "$ scenecc build scene.yaml    # where an image is replaced by something unreadable after the check",
        "Look at the file that the message names; leave out a camera's `shader`.",
    ),
    Code(
        "SC808",
        "error",
        "the engine refuses a body",
        "A plan that was written or changed by hand asks a body for something that its type does not have in the "
        "engine (a damping of a static body), or for a value that the engine does not take. Plans compiled from scene "
        "files are checked before.",
        "$ scenecc build plan.json    # a plan whose static body was given a `linear_damping`",
        "Take the property out of the plan, or compile the plan from the scene file again.",
    ),
    Code(
        "SC809",
        "error",
        "a name that the environment has already",
        "ManiSkill keeps one actor or articulation for each name of an environment, and the scene brings an object of "
        "a name that is taken: by something that the task built before, or by the robot of its agent.",
        '$ python task.py    # whose `_load_scene` calls `scenecc.maniskill.load_into(self.scene, "scene.yaml")` twice',
        "Give one of them another name, or use the file as a prefab under a name of its own. If it is the robot of the "
        "task's agent, leave it out of the file, or derive the task from the class that "
        "`scenecc.maniskill.register_env` returns, where the agent's robot is the file's.",
    ),
    Code(
        "SC810",
        "error",
        "settings that contradict the environment",
        "A ManiSkill environment has its simulation before the scene is loaded into it. What `physics` leaves out is "
        "the environment's; what it says must be what the environment has, and ManiSkill counts whole steps a second.",
        "$ python task.py    # which loads a file with `gravity: [0, 0, -1.62]` into an environment on Earth",
        'Make the environment with `sim_config=scenecc.maniskill.sim_config("scene.yaml")`, or leave the key out.',
    ),
    Code(
        "SC811",
        "error",
        "something that ManiSkill has no place for",
        "ManiSkill handles an object of all its environments as one: with one type of body, cameras that every "
        "environment has, hidden objects that touch nothing, and planes that are the same everywhere where "
        "environments share one simulation.",
        "$ python task.py    # which loads a file whose entity has `hidden: true` and `shapes`, which collide",
        "Do what the hint says; bare SAPIEN (`scenecc.load_scene` without `scene=`) builds such a scene as it is.",
    ),
    Code(
        "SC812",
        "error",
        "the packages that pictures need are missing",
        "`scenecc render` writes pictures with Pillow, and films with ffmpeg, which come with the extra `pictures`.",
        "$ scenecc render scene.yaml -o scene.png    # in an environment without Pillow",
        "`pip install 'scenecc[pictures]'`. `SceneBatch.cameras[name].capture` gives pictures as arrays, without it.",
    ),
    Code(
        "SC814",
        "error",
        "a picture cannot be made",
        "The renderer failed with a picture, for want of memory perhaps, or the encoder with a film; the message has "
        "their words.",
        "$ scenecc render scene.yaml -o large.png --size 16384x16384    # on a device with little memory",
        "Take a smaller picture, or fewer scenes.",
    ),
    Code(
        "SC818",
        "error",
        "a file cannot be written for want of room",
        "The disk that a file was to be written to is full, has a quota that is used up, or fails. "
        "Files that were there before are left as they were.",
        "$ scenecc build scene.yaml -o /dev/full",
        "Make room, or name a file on another disk after -o.",
    ),
    Code(
        "SC820",
        "error",
        "the simulation diverges",
        "A body, a link or a joint is not finite any more, or beyond 1e6 (m, m/s, rad or rad/s), where single "
        "precision means nothing: the engine cannot solve this scene with this time step. SAPIEN goes on without a "
        "word, and draws nothing of what is not finite.",
        "$ scenecc build scene.yaml --steps 100    # where drives are too strong for the time step",
        "Take a smaller `timestep`, weaker drives and springs, or masses and inertias that differ less. See whether "
        "a number is in another unit than the language's (m, kg, s, rad).",
        at_fault="scene",
    ),
    Code(
        "SC821",
        "error",
        "more physical materials than the engine can number",
        "PhysX numbers the materials of a process in 16 bits. Beside its default one there is room for 65 534, and "
        "SAPIEN crashes on one more. Each material that has a friction or a restitution is one of them; where these "
        "differ from scene to scene, there is one for each of their values. Those that other code makes are "
        "not counted.",
        "$ scenecc build scene.yaml --num-scenes 4096    # where each of 20 entities draws its friction",
        "Build fewer scenes in one process (`--scenes 0:2048`, `scene_idxs=`), close batches that are no longer "
        "needed, or draw from few values: `{choice: [0.2, 0.4, 0.6]}`.",
    ),
)

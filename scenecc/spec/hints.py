"""Tables of hints for common mistakes: unknown keys, misplaced keys, words of other tools."""

from __future__ import annotations

INSTANCE_HINT = (
    "a prefab may hold many objects: write `override: {{NAME: {{{entry}}}}}` for one of them, or `with: {{{entry}}}` "
    "where it has such a parameter"
)

PARAM_HINT = "a parameter of the prefab is written `with: {{{entry}}}`; `scenecc prefabs NAME` lists them"

VARIANTS_HINT = "use `variants` of the entity for differences in structure"

PARTS_HINT = "only the numbers, files, colours and materials inside it can vary, one by one"

PHYSICS_HINT = "settings under `physics` are the same in all scenes"

SEPARATE_ENTITIES_HINT = "declare an entity for each value, with `scene_idxs` of its own"

SHARED_ROBOT_KEYS = frozenset(
    (
        "beyond_limits",
        "disable_self_collisions",
        "sapien_bits",
        "collision_is_visual",
        "load_multiple_collisions",
        "decomposition",
    )
)
"""Keys of an articulation that cannot differ between scenes."""

FORM_SYNONYMS = {
    **dict.fromkeys(("range", "random", "rand", "between", "min", "low"), "uniform: [low, high]"),
    **dict.fromkeys(("randint", "integer", "int"), "integers: [low, high]"),
    **dict.fromkeys(("gauss", "gaussian", "mean"), "normal: [mean, std]"),
    **dict.fromkeys(("one_of", "oneof", "any_of", "options", "choices", "random_choice", "sample"), "choice: [a, b]"),
    **dict.fromkeys(("values", "list"), "per_scene: [a, b]"),
}
"""Name of a form in other tools → the form here."""


def _meanings(words: dict[str, str]) -> dict[str, tuple[str, ...]]:
    """Returns each word → what it may mean here. `words`: what is meant → the words for it."""
    found: dict[str, tuple[str, ...]] = {}
    for meant, those in words.items():
        for word in those.split():
            found[word] = (*found.get(word, ()), *meant.split())
    return found


HALVES = _meanings(
    {
        "half_size radius": "size sizes extents dimensions edges",
        "half_length": "height length h",
        "radius": "diameter width d",
    }
)
"""Unknown key → keys that take half of its value."""

MISSING_KEY_HINTS: dict[str, str] = {
    "color": "write `color: [3, 3, 3]`: its numbers also set the brightness",
    "inertia": "write `inertia: [ixx, iyy, izz]`, along the axes of `com`",
    "radius": "write `radius: …` [m]",
    "half_size": "write `half_size: [x, y, z]`, from the centre to its faces [m]",
    "side": "write `side: left`, or right, front or back",
    "of": "write `of: NAME`, the entity beside it",
    "half_length": "write `half_length: …`, half of its straight part [m], and turn it by `axis` or `pose`",
    "pick": "it selects the variant of each scene: `pick: {cycle: [0, 1]}`, or any form over their indices",
}
"""Missing key → hint."""

PLACES = "p pos xyz translation location position base_position"
"""Words for the position of a pose."""

ROTATIONS = "q quat quaternion wxyz xyzw orientation rotation rot base_orientation euler euler_deg angles rpy rpy_deg"
"""Words for the rotation of a pose."""

KEY_SYNONYMS = _meanings(
    {
        "file": "filename path src uri mesh_file mesh",
        "pose origin com": f"{PLACES} initial_pose",
        "pose com": "origin",
        "origin": "pose",
        "com": "center_of_mass cog center_of_gravity com_offset",
        "look_at": "target lookat",
        "entities": "actors objects bodies robots articulations models worldbody world scene",
        "physics": "option sim simulation sim_config physics_config",
        "constraints": "joint joints equality welds",
        "mount": "parent attached_to attach_to attach parent_link link",
        "ambient_light": "ambient",
        "solver_position_iterations": "iterations solver_iterations num_iterations solver",
        "limits": "range limit joint_limits",
        "max_velocity": "velocity velocity_limit",
        "body_type": "motion_type actor_type",
        "shapes": "geometries",
        "color base_color": "rgb rgba colour color diffuse albedo",
        "base_color_texture": "texture texture_file diffuse_texture albedo_texture",
        "half_size": "half_extents half_extent",
        "num_scenes": "num_envs n_envs num_environments batch_size",
        "qpos": "joint_positions joint_pos init_qpos initial_qpos",
        "qvel": "joint_velocities init_qvel",
        "q": "wxyz",
        "static_friction": "friction mu mu1 lateral_friction",
        "friction_force": "frictionloss friction_loss coulomb_friction dry_friction",
        "linear_velocity velocity_target": "linvel lin_vel velocity vel",
        "angular_velocity": "angvel ang_vel angular_vel",
        "timestep": "dt time_step sim_dt",
        "stiffness": "kp p_gain p",
        "damping": "kd kv d_gain d",
        "force_limit": "effort max_force forcerange",
        "mode": "drive_mode",
        "radius": "r",
        "parent": "body1 body_a entity1 a",
        "child": "body2 body_b entity2 b to",
        "that": "condition check expr expression assert",
        "after": "at time when",
        "because": "reason message msg",
        "count": "range times n num",
        "at pose": "xy offset",
        "relative_to": "parent frame reference relative parent_frame",
        "map": "sky skybox hdr envmap hdri",
        "draws": "random distributions randomness draw",
        "apart": "margin clearance min_distance",
        "name": "title",
        "default": "value init initial",
        "min": "low lower minimum",
        "max": "high upper maximum",
        "options": "choices values enum",
        "type": "kind dtype",
        "description": "doc help unit",
        "metallic": "metalness metal",
        "outer_fov": "angle cone_angle spot_angle",
        "fovx": "hfov",
        "fovy": "vfov",
        "direction": "dir",
        "mass": "base_mass weight mass_kg",
        "include": "import imports",
        "params with": "variables vars constants args arguments parameters params",
        "restitution": "bounce bounciness",
        "region": "area bounds",
        "inside": "into in",
        "on": "ontop on_top on_top_of onto surface",
        "environment scene_idxs": "env envs",
        "enabled": "active is_enabled",
        "use": "extends template inherit uses using prefab instance",
        "use parent": "from",
        "pose": "transform",
        "orthographic": "ortho orthogonal",
        "intrinsic": "k intrinsics camera_matrix",
        "enable_ccd": "ccd",
        "enable_tgs": "tgs",
        "target": "target_position position_target setpoint",
        "velocity_target": "target_velocity",
        "width": "w",
        "height": "h",
    }
)
"""Unknown key → the keys here, for names that fuzzy matching would not find."""

BRIGHTNESS = frozenset(("intensity", "power", "energy", "brightness"))
"""Words for the brightness of a light, which its colour sets."""

MISPLACED_KEYS: tuple[tuple[str, str, str], ...] = (
    ("CameraSpec", "clip clipping near_far clip_range", "write `near: @first` and `far: @last` [m]"),
    ("CameraSpec", "resolution res image_size img_size size", "write `width: @first` and `height: @last` [px]"),
    ("PoseMapping", f"{PLACES} initial_pose eye", "write `p: @`"),
    ("RigidBodyKeys", "type", "write `body_type: static`, or a shape: `shapes: [{type: box, …}]`"),
    ("ArticulationKeys PartKeys", "type", "remove it: `urdf`, `mjcf` or `root` make it an articulation"),
    ("RigidBodyKeys", "visual", "write `visuals: [@]`, a list of shapes that are only visible"),
    ("RigidBodyKeys", "collision", "write `collisions: [@]`, a list of shapes that only collide"),
    ("ShapeKeys BodyKeys",
     ("collision collidable collide can_collide has_collision contype conaffinity disable_collision "
      "collision_enabled"),
     "write `visuals` instead of `shapes` for shapes that do not collide; `collision_group` selects which collide"),
    ("RigidBodyKeys ShapeKeys", "scale global_scaling",
     "only meshes and robots have a `scale`: write the size of the shape itself"),
    ("RigidBodyKeys", "usd usda usdc sdf world_file", "convert it: `scenecc import FILE -o scene.yaml`"),
    ("RigidBodyKeys", "joint joints children links link",
     "a body has no joints: connect two with `constraints`, or write an articulation `root: {name: …, children: […]}`"),
    ("CameraSpec", "type kind", "remove it: every camera takes colour, depth and segmentation"),
    ("RigidBodyKeys ArticulationKeys PartKeys", "parent attached_to parent_link mount",
     "write `pose: {relative_to: @}`, or connect them: `constraints: {NAME: {type: weld, …}}`"),
    ("ConstraintKeys TreeJoint", "anchor pivot anchor1 anchor2",
     "write `pose_in_child: @`, the place in the frame of the child; that in the parent follows from it"),
    ("ConstraintKeys TreeJoint TreeLink", "parent attached_to parent_link child child_link",
     "write the link in the `children` of its parent, without this key"),
    ("TreeJoint ConstraintKeys", "motor stiffness damping spring_constant k",
     "write it under `drive`: `drive: {@here: @}`"),
    ("RigidBodyKeys", "freejoint free_joint", "remove it: a body with `body_type: dynamic` moves freely"),
    ("RigidBodyKeys", "inertia", "write `inertial: {mass: 1, inertia: @}`, with its mass [kg]"),
    ("ArticulationKeys PartKeys", "com center_of_mass", "set it on links: `links: {NAME: {com: @}}`"),
    ("RigidBodyKeys ArticulationKeys PartKeys ShapeKeys Physical DefaultMaterial",
     ("surface_velocity conveyor belt_velocity surfacevel"),
     "PhysX in SAPIEN has no moving surfaces: write rollers, links that a drive turns by `velocity_target`"),
    ("RigidBodyKeys ArticulationKeys PartKeys", "disable_gravity gravcomp no_gravity", "write `gravity: false`"),
    ("ArticulationKeys", "self_collision self_collisions enable_self_collisions",
     "write `disable_self_collisions: true`; without it, links collide with each other"),
    ("RigidBodyKeys", "entity template prototype", "write its keys here, beside `repeat`: each copy has all of them"),
    ("RigidBodyKeys", "qpos qvel drives qpos_deg drive_target",
     "a body has no joints: the entity of a robot has its file, `urdf: …` or `mjcf: …`, or `root: {…}`"),
    ("RigidBodyKeys", "for", "copies are `repeat: {i: {count: 4}}`"),
    ("RigidBodyKeys", "count num copies n number", "write `repeat: {i: {count: @}}`"),
    ("ArticulationKeys PartKeys", "fix_base fixed_base base_fixed use_fixed_base fixed fix",
     "write `fix_root_link: @`"),
    ("ArticulationKeys PartKeys", "static immovable is_static",
     "write `fix_root_link: true`, or `body_type: static` if its joints never move either"),
    ("ArticulationKeys PartKeys", "kinematic is_kinematic", "write `body_type: kinematic`: its joints then never move"),
    ("PlaceSpec", "beside adjacent left_of", "write `next_to: {of: @, side: left, gap: 0.02}`"),
    ("PlaceSpec", "right_of", "write `next_to: {of: @, side: right, gap: 0.02}`"),
    ("PlaceSpec", "behind", "write `next_to: {of: @, side: back, gap: 0.02}`"),
    ("PlaceSpec", "in_front_of", "write `next_to: {of: @, side: front, gap: 0.02}`"),
    ("PlaceSpec", "position pos xyz location p center", "write `at: [x, y]`; the height follows from `on`"),
    ("PlaceSpec", "rotate rotation heading orientation", "write `yaw: …` [rad] or `yaw_deg: …`"),
    ("TreeLink", "pose", "write it as the `origin` of its joint: `joint: {origin: …}`; of the root, beside `root`"),
    ("SceneFile", "uid robot robot_uid robot_uids agent agents",
     "write `entities: {robot: {use: scenecc:table_scene, with: {robot: @}}}`, or give its file: `{urdf: …}`"),
    ("SceneFile", "unit units length_unit up_axis coordinate_system", "remove it: units are SI, and z is up"),
    ("SceneFile", "metadata meta author tags", "remove it, or write a comment: `# …`; `description` takes a text"),
    ("PhysicsSpec SceneFile", "substeps", "PhysX has no substeps: write a smaller `timestep`"),
    ("SceneFile", "asset assets meshes textures",
     "name a file where it is used: `shapes: [{type: convex_mesh, file: …}]`, `urdf: …` or `base_color_texture: …`"),
    ("SceneFile", "ground floor plane ground_plane",
     "write it under `entities`: `entities: {ground: {use: scenecc:ground}}`"),
    ("SceneFile", "default defaults",
     "repeat values by an anchor and `<<: *NAME`, or name materials under `materials`"),
    ("SceneFile", "version format schema", "remove it: `scenecc: 1` is the version of the language"),
    ("SceneFile", "randomization randomize domain_randomization distributions",
     "write a form instead of a value, as in `mass: {uniform: [0.1, 0.2]}`"),
    ("RigidBodyKeys", "with prefix", "write it beside `use`: `{use: FILE, @key: @}`"),
    ("RigidBodyKeys", "pick", "write it beside `variants`: `{variants: [{…}, {…}], pick: @}`"),
    ("RigidBodyKeys", "uses using prefab instance extends", "write `use: @`"),
    ("BodyKeys LinkKeys", "visible", "write `visibility: 0`, or 1 for what is visible"),
    ("VisualKeys", "visible visual visualize render",
     "write `collisions` instead of `shapes` for shapes that are not visible"),
    ("LightKeys VisualKeys BodyKeys Visual", "opacity alpha transparency transparent",
     "it is the fourth number of a colour: `color: [r, g, b, 0.5]`"),
    ("CollisionKeys BodyKeys LinkKeys", "collision_mask collision_filter layer layers mask",
     "write a `collision_group`, which is named under `collision_groups`"),
    ("RigidBodyKeys", "urdf mjcf root",
     "`variants` takes bodies only; the file of a robot can vary: `urdf: {cycle: [a.urdf, b.urdf]}`"),
    ("ArticulationKeys PartKeys", "urdf mjcf root", "an articulation has one of `urdf`, `mjcf` and `root`"),
    ("ArticulationKeys PartKeys", "shapes collisions visuals",
     "the links of a tree have shapes: `root: {name: base, @key: @}`; those of a robot come from its file"),
    ("ArticulationKeys PartKeys", "mass inertial linear_damping angular_damping",
     "set it on links: `links: {NAME: {@key: @}}`"),
    ("ArticulationKeys PartKeys", "color rgba colour", "the colours of a robot come from its file"),
    ("TreeLink", "color rgba colour", "write it in the shapes of the link: `shapes: [{…, color: @}]`"),
    ("ShapeKeys", "texture texture_file diffuse_texture albedo_texture",
     "write it in the material: `material: {visual: {base_color_texture: @}}`"),
    ("ShapeKeys", "decomposition", "only `convex_parts` are decomposed: write `type: convex_parts`"),
    ("Material", "color rgba colour", "write it under `visual`: `visual: {base_color: @}`"),
    ("MjcfKeys", "loader",
     "remove it: MuJoCo reads every MJCF; `scenecc decompile` writes ManiSkill's robots as trees of links"),
    ("ArticulationKeys PartKeys", "keyframe", "only `mjcf` has keyframes: write `qpos: […]`"),
    ("ArticulationKeys PartKeys", "controller control_mode controllers",
     'a scene has drives, not controllers: `drives: {".*": {stiffness: 1000, damping: 100}}`'),
    ("JointKeys TreeJoint", "position pos init initial init_pos start angle qpos target",
     "write it beside `joints` or `root`, at the articulation: `qpos: {@name: @}`"),
    ("JointKeys TreeJoint", "effort max_force forcerange", "set it on the drive: `drives: {@name: {force_limit: @}}`"),
    ("DistanceConstraint", "length distance", "write `limits: [@, @]`"),
    ("JointKeys TreeJoint", "stiffness damping force_limit kp kd kv",
     "set it on the drive: `drives: {@name: {@here: @}}`"),
    ("ArticulationKeys PartKeys", "stiffness damping force_limit kp kd kv",
     'set it on drives: `drives: {".*": {@here: @}}`'),
    ("RigidBodyKeys ArticulationKeys PartKeys", "uid robot robot_uid robot_uids",
     ("give the robot's file, `urdf: …` or `mjcf: …`, or use ManiSkill's robots: `{use: scenecc:table_scene, "
      "with: {robot: @}}`")),
    ("ConstraintKeys", "axis",
     "only `hinge` and `slider` have an axis; here it is x of both poses, which `rpy_deg: [0, -90, 0]` turns to z"),
)  # fmt: skip
"""Rows of models of `spec`, unknown keys and a hint. A row applies to a mapping of one of its models; the first row
that applies is used. A key that belongs in a mapping beside, inside or around needs no row: its place is found. In a
hint, `@` is the value of the unknown key, `[@]` a list of it, `@first` and `@last` its ends, `@key` the key, `@here`
its name here, and `@name` the name of the mapping that has it."""

SHAPE_LIST_HINTS: dict[str, str] = {
    "mesh": "write `type: convex_mesh`, convex_parts or triangle_mesh: a `mesh` is only visible, under `visuals`",
    "tiled_plane": "a `tiled_plane` is only visible: write it under `visuals`",
    "convex_parts": "`convex_parts` always collide: write them under `shapes` or `collisions`, or use a visible `mesh`",
    "triangle_mesh": "a `triangle_mesh` always collides: write it under `shapes` or `collisions`",
}
"""Shape type → hint for a list that does not allow it."""

VALUE_SYNONYMS = _meanings(
    {
        "static weld": "fixed",
        "static": "immovable frozen",
        "dynamic weld fixed": "rigid",
        "dynamic": "movable free active actor",
        "box": "cube cuboid",
        "sphere ball": "ball",
        "capsule": "pill",
        "convex_mesh": "convex hull convex_hull",
        "triangle_mesh": "trimesh nonconvex",
        "heightfield": "terrain hfield",
        "directional": "sun",
        "weld fixed static": "fixed_joint fix weld glue",
        "ball": "ball_joint spherical connect socket point2point",
        "hinge revolute": "revolute hinge rotary rotational",
        "slider prismatic": "prismatic slide slider sliding linear translational",
        "plane": "ground floor",
        "number": "float double real num",
        "integer": "int whole",
        "string": "str text",
        "boolean": "bool flag",
        "vector": "vec3 vector3 array",
        "color": "colour rgb rgba",
        "choice": "enum option",
        "file": "path",
        "convex_mesh mesh file": "mesh obj stl glb",
        "force vector": "position",
        "force": "velocity torque effort",
        "distance": "spring rope cable",
        "ring": "tube pipe hollow_cylinder",
        "convex_parts coacd": "coacd convex_decomposition decomposition vhacd",
        "point": "omni lamp bulb omnidirectional",
        "rt": "raytracing raytraced path_tracing rt-fast rt-med",
        "back": "behind rear",
    }
)
"""Unknown value → the values that may be meant."""

VALUE_HINTS: dict[str, tuple[tuple[str, str], ...]] = {
    "dynamic": (("static", "leave `body_type` out: the links of an articulation are dynamic"),),
    **dict.fromkeys(
        ("ball", "spherical"),
        (("continuous", "write three `revolute` joints, one for each axis, with small links between"),),
    ),
    **dict.fromkeys(("floating", "free"), (("continuous", "for a free robot write `fix_root_link: false`"),)),
    "ellipsoid": (("sphere", "write a `sphere`, or a `convex_mesh` with a file of that shape"),),
    **dict.fromkeys(
        ("hdri", "skybox", "environment", "sky"),
        (("directional", "remove the light, and write `environment: {map: FILE}`"),),
    ),
    "ambient": (("directional", "remove the light, and write `environment: {ambient_light: [0.3, 0.3, 0.3]}`"),),
}
"""Unknown value → pairs of a value and a hint. The hint applies where that value is allowed."""

LENGTH_HINTS: dict[tuple[str, int], str] = {
    ("pose", 4): "a matrix is {matrix: [[…], […], […], […]]}, a rotation {q: [w, x, y, z]}",
    ("inertia", 6): "[ixx, iyy, izz] along the axes of `com`: turn `com` until the others are 0",
}
"""Key and wrong number of values → hint."""

_UNSUPPORTED = {
    "tendons": "tendons",
    "stereo depth sensors": "stereo",
    "point clouds": "point_clouds point_cloud",
    "vertices in the file": "vertices triangles faces",
    "render properties by name": "properties",
    "cone limits (SAPIEN records them and never applies them)": "cone",
    "pyramid limits (SAPIEN records them and never applies them)": "pyramid",
    "triggers (SAPIEN records `is_trigger` and never applies it)": "is_trigger trigger",
    "soft bodies, cloth and fluids (SAPIEN simulates rigid bodies; `use: scenecc:rope` is a chain of them)": (
        "soft soft_body softbody soft_bodies deformable deformables deformable_body cloth fabric fluid liquid "
        "particle particles mpm fem flex flexcomp tetmesh youngs_modulus young_modulus poissons_ratio poisson_ratio "
        "elasticity"
    ),
}

UNSUPPORTED_KEYS = {word: what for what, words in _UNSUPPORTED.items() for word in words.split()}
"""Key or value that the language leaves out → what it means."""

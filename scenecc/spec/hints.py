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
    return {word: tuple(meant.split()) for meant, those in words.items() for word in those.split()}


HALVES = _meanings(
    {
        "half_size radius": "size sizes extents dimensions edges",
        "half_length": "height length h",
        "radius": "diameter width d",
    }
)
"""Unknown key → keys that take half of its value."""

SYNTAX_HINTS: dict[str, str] = {
    "include": "write the files as a list: `include: [FILE]`",
    "repeat": "for 4 copies write `{i: {count: 4}}`",
}
"""Key → syntax of its value."""

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

KEY_SYNONYMS = _meanings(
    {
        "file": "filename path src uri mesh_file mesh",
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
        "at": "xy offset",
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
        "inside": "into",
        "on": "ontop on_top on_top_of onto surface",
        "environment scene_idxs": "env envs",
        "enabled": "active is_enabled",
        "use": "extends template inherit",
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

PLACES = "p pos xyz translation location position base_position"
"""Words for the position of a pose."""

ROTATIONS = "q quat quaternion wxyz xyzw orientation rotation rot base_orientation euler euler_deg angles rpy rpy_deg"
"""Words for the rotation of a pose."""

MISPLACED_KEYS: tuple[tuple[str, str, str], ...] = (
    ("locked_axes", "type", "write `body_type: static`, or a shape: `shapes: [{type: box, …}]`"),
    ("fix_root_link", "type", "remove it: `urdf`, `mjcf` or `root` make it an articulation"),
    ("locked_axes", ("half_size half_length geometry geom geoms box sphere capsule cylinder collider "
     "shape sizes extents dimensions edges size radius"),
     "write shapes in one of the lists `shapes`, `collisions` and `visuals`: `shapes: [{type: box, …}]`"),
    ("locked_axes", "mesh file filename path uri src",
     "write it in a shape: `shapes: [{type: convex_mesh, file: @}]`; a robot is `urdf: …` or `mjcf: …`"),
    ("locked_axes", "visual", "write `visuals: [@]`, a list of shapes that are only visible"),
    ("locked_axes", "collision", "write `collisions: [@]`, a list of shapes that only collide"),
    ("material", ("collision collidable collide can_collide has_collision contype conaffinity disable_collision "
     "collision_enabled"),
     "write `visuals` instead of `shapes` for shapes that do not collide; `collision_group` selects which collide"),
    ("locked_axes pose", "scale global_scaling",
     "only meshes and robots have a `scale`: write the size of the shape itself"),
    ("locked_axes", "usd usda usdc sdf world_file", "convert it: `scenecc import FILE -o scene.yaml`"),
    ("locked_axes", "xml", "write `mjcf: @`"),
    ("locked_axes", "joint joints children links link",
     "a body has no joints: connect two with `constraints`, or write an articulation `root: {name: …, children: […]}`"),
    ("entities", "joint joints equality welds", "did you mean `constraints`?"),
    ("mount", "parent attached_to attach_to attach parent_link link", "did you mean `mount`?"),
    ("fovy", "type kind", "remove it: every camera takes colour, depth and segmentation"),
    ("locked_axes fix_root_link", "parent attached_to parent_link mount",
     "write `pose: {relative_to: @}`, or connect them: `constraints: {NAME: {type: weld, …}}`"),
    ("pose_in_child", "anchor pivot anchor1 anchor2",
     "write `pose_in_child: @`, the place in the frame of the child; that in the parent follows from it"),
    ("pose_in_child", "parent attached_to parent_link child child_link",
     "write the link in the `children` of its parent, without this key"),
    ("pose_in_child", "lock locked fixed_axes", "equal limits lock an axis: `limits: {x: [0, 0]}`"),
    ("pose_in_child", "motor stiffness damping spring_constant k", "write it under `drive`: `drive: {@here: @}`"),
    ("children", "parent parent_link attached_to", "write the link in the `children` of its parent, without this key"),
    ("children", "type joint_type", "write it in the joint: `joint: {type: @}`"),
    ("locked_axes", "freejoint free_joint", "remove it: a body with `body_type: dynamic` moves freely"),
    ("locked_axes", "inertia", "write `inertial: {mass: 1, inertia: @}`, with its mass [kg]"),
    ("com", "center_of_mass cog center_of_gravity com_offset",
     "write `com: @`, a position in the frame of the body [m]"),
    ("fix_root_link", "com center_of_mass", "set it on links: `links: {NAME: {com: @}}`"),
    ("material", "com center_of_mass", "write `com: @` beside `shapes`: it is a property of the body"),
    ("locked_axes fix_root_link material static_friction", "surface_velocity conveyor belt_velocity surfacevel",
     "PhysX in SAPIEN has no moving surfaces: write rollers, links that a drive turns by `velocity_target`"),
    ("locked_axes fix_root_link", "disable_gravity gravcomp no_gravity", "write `gravity: false`"),
    ("drive", "damping stiffness force_limit max_force effort motor target velocity_target",
     "write it in the drive: `drive: {stiffness: …, damping: …, force_limit: …}`"),
    ("disable_self_collisions", "self_collision self_collisions enable_self_collisions",
     "write `disable_self_collisions: true`; without it, links collide with each other"),
    ("locked_axes", "entity template prototype", "write its keys here, beside `repeat`: each copy has all of them"),
    ("locked_axes", "qpos qvel drives qpos_deg drive_target",
     "a body has no joints: the entity of a robot has its file, `urdf: …` or `mjcf: …`, or `root: {…}`"),
    ("locked_axes", "for", "copies are `repeat: {i: {count: 4}}`"),
    ("locked_axes", "count num copies n number", "write `repeat: {i: {count: @}}`"),
    ("fix_root_link", "fix_base fixed_base base_fixed use_fixed_base fixed fix", "write `fix_root_link: @`"),
    ("fix_root_link", "static immovable is_static",
     "write `fix_root_link: true`, or `body_type: static` if its joints never move either"),
    ("fix_root_link", "kinematic is_kinematic", "write `body_type: kinematic`: its joints then never move"),
    ("next_to", "beside adjacent left_of", "write `next_to: {of: @, side: left, gap: 0.02}`"),
    ("next_to", "right_of", "write `next_to: {of: @, side: right, gap: 0.02}`"),
    ("next_to", "behind", "write `next_to: {of: @, side: back, gap: 0.02}`"),
    ("next_to", "in_front_of", "write `next_to: {of: @, side: front, gap: 0.02}`"),
    ("next_to", "position pos xyz location p center", "write `at: [x, y]`; the height follows from `on`"),
    ("next_to", "rotate rotation heading orientation", "write `yaw: …` [rad] or `yaw_deg: …`"),
    ("material", "body_type", "write `@key: @` beside `shapes`: it is a property of the body"),
    ("locked_axes", "static immovable is_static fixed fix freeze frozen locked fix_root_link fix_base fixed_base",
     "write `body_type: static`"),
    ("locked_axes", "kinematic is_kinematic", "write `body_type: kinematic`"),
    ("locked_axes", "dynamic is_dynamic movable", "`body_type` is one of dynamic, kinematic and static"),
    ("rpy_deg", "quat quaternion orientation rotation rot",
     "write `q: [w, x, y, z]`, w first, or `rpy_deg: [roll, pitch, yaw]`"),
    ("rpy_deg", "euler angles euler_deg rpy rpy_deg", "write `rpy_deg: [roll, pitch, yaw]`, or `rpy` in radians"),
    ("pose", ROTATIONS,
     "write it in the pose: `pose: {p: [x, y, z], q: [w, x, y, z]}`, or `rpy_deg: [roll, pitch, yaw]` for `q`"),
    ("origin", ROTATIONS,
     "write it in the origin: `origin: {p: [x, y, z], rpy_deg: [roll, pitch, yaw]}`"),
    ("rpy_deg", "xyzw", "`q` has w first: `q: [w, x, y, z]`"),
    ("rpy_deg", "eye", "write `p: @`"),
    ("rpy_deg", "target lookat", "write `look_at: @`"),
    ("rpy_deg", "heading", "write `rpy: [0, 0, @]`, or `rpy_deg: [0, 0, @]` in degrees"),
    ("rpy_deg", f"{PLACES} initial_pose", "write `p: @`"),
    ("pose", f"{PLACES} initial_pose origin", "did you mean `pose`?"),
    ("locked_axes", "scene_idxs repeat if pose", "write it beside `variants`, for all variants"),
    ("children", "pose", "write it as the `origin` of its joint: `joint: {origin: …}`; of the root, beside `root`"),
    ("origin", f"{PLACES} initial_pose pose", "did you mean `origin`?"),
    ("com", f"{PLACES} initial_pose origin", "did you mean `com`?"),
    ("entities", "gravity", "write it under `physics`: `physics: {gravity: [@]}`"),
    ("entities", "timestep dt sim_dt", "write it under `physics`: `physics: {timestep: @}`"),
    ("entities", "contact_offset", "write it under `physics`: `physics: {contact_offset: @}`"),
    ("entities", "default_material", "write it under `physics`: `physics: {default_material: @}`"),
    ("entities", "actors objects bodies robots articulations models worldbody world scene",
     "did you mean `entities`? it holds bodies and robots by name"),
    ("entities", "uid robot robot_uid robot_uids",
     "write `entities: {robot: {use: scenecc:table_scene, with: {robot: @}}}`, or give its file: `{urdf: …}`"),
    ("entities", "option sim simulation sim_config physics_config", "did you mean `physics`?"),
    ("entities", "ambient", "write it under `environment`: `environment: {ambient_light: @}`"),
    ("entities", "unit units length_unit up_axis coordinate_system", "remove it: units are SI, and z is up"),
    ("entities", "agent agents",
     "write `entities: {robot: {urdf: …}}`, or `{use: scenecc:table_scene, with: {robot: panda}}`"),
    ("entities", "render renderer viewer camera_config",
     "remove it: `scenecc render` and `scenecc view` have options for this"),
    ("entities", "solver iterations", "write it under `physics`: `physics: {solver_position_iterations: 10}`"),
    ("entities", "task reward success goal", "a scene has no task: write the conditions that must hold under `expect`"),
    ("timestep", "friction default_friction restitution",
     "write `default_material: {static_friction: 0.5, dynamic_friction: 0.5, restitution: 0.1}`"),
    ("timestep", "iterations solver_iterations num_iterations", "write `solver_position_iterations: @`"),
    ("timestep", "gpu cuda device backend", "remove it: thousands of scenes run on a GPU through ManiSkill"),
    ("entities", "metadata meta author tags", "remove it, or write a comment: `# …`; `description` takes a text"),
    ("timestep entities", "substeps", "PhysX has no substeps: write a smaller `timestep`"),
    ("entities", "asset assets meshes textures",
     "name a file where it is used: `shapes: [{type: convex_mesh, file: …}]`, `urdf: …` or `base_color_texture: …`"),
    ("entities", "ground floor plane ground_plane",
     "write it under `entities`: `entities: {ground: {use: scenecc:ground}}`"),
    ("entities", "default defaults", "repeat values by an anchor and `<<: *NAME`, or name materials under `materials`"),
    ("entities", "version format schema", "remove it: `scenecc: 1` is the version of the language"),
    ("entities", "randomization randomize domain_randomization distributions",
     "write a form instead of a value, as in `mass: {uniform: [0.1, 0.2]}`"),
    ("entities", "ambient_light", "write it under `environment`: `environment: {ambient_light: @}`"),
    ("color", " ".join(BRIGHTNESS), "its numbers also set the brightness: `color: [3, 3, 3]`"),
    ("fovy", "resolution image_size size", "write `width: 640` and `height: 480` [px]"),
    ("outer_radius", "radius thickness", "a ring has an `inner_radius` and an `outer_radius`"),
    ("locked_axes", "with prefix", "write it beside `use`: `{use: FILE, @key: @}`"),
    ("locked_axes", "uses using prefab instance", "write `use: @`"),
    ("locked_axes", "pick", "write it beside `variants`: `{variants: [{…}, {…}], pick: @}`"),
    ("visibility", "visible", "write `visibility: 0`, or 1 for what is visible"),
    ("front_face", "visible visual visualize render",
     "write `collisions` instead of `shapes` for shapes that are not visible"),
    ("color base_color", "opacity alpha transparency transparent",
     "it is the fourth number of a colour: `color: [r, g, b, 0.5]`"),
    ("collision_bits", "collision_mask collision_filter layer layers mask",
     "write a `collision_group`, which is named under `collision_groups`"),
    ("front_face patch_radius", "offset", "write `pose: @`"),
    ("locked_axes", "urdf mjcf root",
     "`variants` takes bodies only; the file of a robot can vary: `urdf: {cycle: [a.urdf, b.urdf]}`"),
    ("fix_root_link", "urdf mjcf root", "an articulation has one of `urdf`, `mjcf` and `root`"),
    ("fix_root_link", "shapes collisions visuals",
     "the links of a tree have shapes: `root: {name: base, @key: @}`; those of a robot come from its file"),
    ("fix_root_link", "mass inertial linear_damping angular_damping", "set it on links: `links: {NAME: {@key: @}}`"),
    ("material", "mass", "write `mass: @` beside `shapes`, or the `density` of this shape"),
    ("fix_root_link", "color rgba colour", "the colours of a robot come from its file"),
    ("children", "color rgba colour", "write it in the shapes of the link: `shapes: [{…, color: @}]`"),
    ("visual", "texture texture_file diffuse_texture albedo_texture",
     "write it under `visual`: `visual: {base_color_texture: @}`"),
    ("material", "texture texture_file diffuse_texture albedo_texture",
     "write it in the material: `material: {visual: {base_color_texture: @}}`"),
    ("material", "decomposition", "only `convex_parts` are decomposed: write `type: convex_parts`"),
    ("visual", "color rgba colour", "write it under `visual`: `visual: {base_color: @}`"),
    ("visual", "base_color roughness metallic specular emission", "write it under `visual`: `visual: {@key: @}`"),
    ("keyframe", "loader",
     "remove it: MuJoCo reads every MJCF; `scenecc decompile` writes ManiSkill's robots as trees of links"),
    ("fix_root_link", "keyframe", "only `mjcf` has keyframes: write `qpos: […]`"),
    ("fix_root_link", "controller control_mode controllers",
     'a scene has drives, not controllers: `drives: {".*": {stiffness: 1000, damping: 100}}`'),
    ("armature", "position pos init initial init_pos start angle qpos target",
     "write it beside `joints` or `root`, at the articulation: `qpos: {@name: @}`"),
    ("limits", "lower upper lower_limit upper_limit min max",
     "write `limits: [low, high]`, or `limits_deg: [low, high]`"),
    ("limits", "range limit", "write `limits: @` in radians or metres, or `limits_deg: @`"),
    ("armature", "effort max_force forcerange", "set it on the drive: `drives: {@name: {force_limit: @}}`"),
    ("limits", "length distance", "write `limits: [@, @]`"),
    ("max_velocity", "velocity velocity_limit", "write `max_velocity: @`"),
    ("armature", "stiffness damping force_limit kp kd kv", "set it on the drive: `drives: {@name: {@here: @}}`"),
    ("fix_root_link", "stiffness damping force_limit kp kd kv",
     'set it on drives: `drives: {".*": {@here: @}}`'),
    ("locked_axes fix_root_link", "uid robot robot_uid robot_uids",
     ("give the robot's file, `urdf: …` or `mjcf: …`, "
      "or use ManiSkill's robots: `{use: scenecc:table_scene, with: {robot: @}}`")),
    ("inside", "in", "write `inside: @`, or `on: @` with a `region`"),
    ("locked_axes", "on inside next_to above below", "write `place: {@key: @}`"),
    ("rpy_deg", "on inside next_to", "write `place: {@key: @}` instead of the pose"),
    ("locked_axes", "num_envs n_envs num_scenes n_scenes", "write `num_scenes: @` at the top of the file"),
    ("fovy", "look_at lookat eye target xyaxes up", "write it in the pose: `pose: {p: […], look_at: […]}`"),
    ("pose_in_parent", "axis",
     "only `hinge` and `slider` have an axis; here it is x of both poses, which `rpy_deg: [0, -90, 0]` turns to z"),
)  # fmt: skip
"""Rows of known keys, unknown keys and a hint. A row applies if the mapping may have one of its known keys; the first
row that applies is used. In a hint, `@` is the value of the unknown key, `[@]` a list of it, `@key`
the key, `@here` its name here, and `@name` the name of the mapping that has it."""

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

"""Runs in a separate process: compiles a model with MuJoCo and returns its arrays.

It opens no files: the model and its files arrive as bytes. It imports almost nothing of scenecc, for a fast start.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from scenecc.robots.mujoco.contact_ranges import touching_bodies

if TYPE_CHECKING:
    from scenecc.worker_process import Answer, Message

_ARRAY_NAMES = """
body_parentid body_weldid body_pos body_quat body_ipos body_iquat body_mass body_subtreemass body_inertia
body_gravcomp body_mocapid
jnt_type jnt_bodyid jnt_pos jnt_axis jnt_range jnt_limited jnt_stiffness jnt_qposadr jnt_dofadr jnt_actfrcrange
jnt_actfrclimited jnt_stiffnesspoly jnt_springyield
dof_damping dof_frictionloss dof_armature dof_dampingpoly
qpos0
qpos_spring
geom_type geom_contype geom_conaffinity geom_condim geom_bodyid geom_dataid geom_matid geom_group geom_size
geom_pos geom_quat geom_friction geom_rgba geom_adhesion geom_surfacevel
mesh_vertadr mesh_vertnum mesh_vert mesh_faceadr mesh_facenum mesh_face mesh_pos mesh_quat mesh_scale
hfield_nrow hfield_ncol hfield_adr hfield_size hfield_data
mat_rgba mat_texid mat_emission mat_specular mat_shininess mat_reflectance mat_metallic mat_roughness
mat_texrepeat mat_texuniform
site_bodyid site_pos site_quat
cam_bodyid cam_mode cam_pos cam_quat cam_fovy cam_resolution
light_bodyid light_type light_active light_castshadow light_cutoff light_pos light_dir light_diffuse light_mode
exclude_signature
eq_type eq_obj1id eq_obj2id eq_objtype eq_active0 eq_data
actuator_trntype actuator_trnid actuator_gaintype actuator_biastype actuator_dyntype actuator_gainprm
actuator_biasprm actuator_gear actuator_forcerange actuator_forcelimited actuator_ctrladr actuator_damping
actuator_dampingpoly actuator_armature actuator_delay actuator_group actuator_ctrllimited actuator_ctrlrange
key_qpos key_ctrl key_qvel key_act key_mpos key_mquat key_plastic
"""

ARRAYS = _ARRAY_NAMES.split()
"""Fields of `mjModel` to return."""

NAMED = {
    "body": "bodies",
    "jnt": "joints",
    "geom": "geoms",
    "mesh": "meshes",
    "hfield": "hfields",
    "mat": "materials",
    "tex": "textures",
    "exclude": "excludes",
    "eq": "equalities",
    "tendon": "tendons",
    "actuator": "actuators",
    "key": "keys",
    "camera": "cameras",
    "light": "lights",
    "flex": "flexes",
}
"""Kinds of elements in `mjModel` → their lists in `MjSpec`."""


MODEL_PREFIX = "model"
"""Name prefix of attached models."""

FLAGS = (
    "CONTACT",
    "FILTERPARENT",
    "GRAVITY",
    "CONSTRAINT",
    "LIMIT",
    "EQUALITY",
    "ACTUATION",
    "SPRING",
    "DAMPER",
    "CLAMPCTRL",
)
"""Flags of `<flag>` to return."""


_MOVES_ALONG_AXIS = {2, 3}
"""`mjJNT_SLIDE` and `mjJNT_HINGE`."""


def compile_model(mujoco: Any, xml: str, assets: dict[str, bytes]) -> Message:
    """Returns the arrays of a model; under "error", MuJoCo's message about an invalid one.

    Args:
        mujoco: the package.
        xml: the model, without includes, with the file names of `assets`.
        assets: content of each file.
    """
    try:
        models = {name: assets.pop(name) for name in list(assets) if name.startswith(MODEL_PREFIX)}
        spec = mujoco.MjSpec.from_string(xml, include=models, assets=assets)
        model = spec.compile()
    except (ValueError, TypeError, RuntimeError, MemoryError) as error:
        return {"error": str(error)}, []
    disable = mujoco.mjtDisableBit
    arrays = {name: getattr(model, name) for name in ARRAYS if hasattr(model, name)}
    data = mujoco.MjData(model)
    # A joint placed outside its limits starts at the limit.
    for joint in model.jnt_limited.nonzero()[0]:
        if int(model.jnt_type[joint]) in _MOVES_ALONG_AXIS:
            place = model.jnt_qposadr[joint]
            data.qpos[place] = data.qpos[place].clip(*model.jnt_range[joint])
    _couple_joints(mujoco, model, data)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    computed = ("xpos", "xquat", "cam_xpos", "cam_xmat", "light_xdir")
    arrays |= {name: getattr(data, name).copy() for name in computed}
    elements = {kind: [_element(one) for one in getattr(spec, several)] for kind, several in NAMED.items()}
    header = {
        "arrays": {name: [array.dtype.str, list(array.shape)] for name, array in arrays.items()},
        "elements": elements,
        "meshes": [[one.file, list(one.scale), list(one.refpos), list(one.refquat)] for one in spec.meshes],
        "option": {
            "timestep": model.opt.timestep,
            "gravity": model.opt.gravity.tolist(),
            "fluid": [model.opt.density, model.opt.viscosity],
            "override": bool(model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE),
            "disableactuator": model.opt.disableactuator,
        },
        "ambient": model.vis.headlight.ambient.tolist() if model.vis.headlight.active else [0.0, 0.0, 0.0],
        "touching": touching_bodies(mujoco, model, data),
        # Flag bits differ between versions.
        "disabled": [name for name in FLAGS if model.opt.disableflags & getattr(disable, f"mjDSBL_{name}", 0)],
    }
    return header, [array.tobytes() for array in arrays.values()]


def _couple_joints(mujoco: Any, model: Any, data: Any) -> None:
    """Moves joints to the positions at which active equalities hold them: constants, and multiples in one tree."""
    pinned: set[int] = set()
    for number, kind in enumerate(model.eq_type):
        if kind != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[number]:
            continue
        factors = model.eq_data[number][:5].tolist()
        joint, source = int(model.eq_obj1id[number]), int(model.eq_obj2id[number]) if any(factors[1:]) else -1
        joints = [joint] if source < 0 else [joint, source]
        trees = set(model.body_treeid[model.jnt_bodyid[joints]].tolist())
        is_constant = source < 0 or source in pinned
        if not _MOVES_ALONG_AXIS.issuperset(model.jnt_type[joints].tolist()) or (
            not is_constant and (any(factors[2:]) or len(trees) > 1)
        ):
            continue
        if is_constant:
            pinned.add(joint)
        place, at = model.jnt_qposadr[joint], model.jnt_qposadr[source]
        moved = 0.0 if source < 0 else float(data.qpos[at] - model.qpos0[at])
        data.qpos[place] = model.qpos0[place] + sum(factor * moved**power for power, factor in enumerate(factors))


def _element(one: Any) -> list[Any]:
    """Returns an element's number, name and line, which MuJoCo gives as `line N`."""
    line = str(one.info).rpartition("line ")[2].split(",")[0].strip()
    return [int(one.id), one.name, int(line) if line.isdigit() else None]


def prepare() -> Answer:
    """Returns the function that answers requests."""
    mujoco: Any = importlib.import_module("mujoco")

    def answer(header: dict[str, Any], parts: list[bytes]) -> Message:
        xml, *files = parts
        return compile_model(mujoco, xml.decode(), dict(zip(header["names"], files, strict=True)))

    return answer

"""Rows of the table of codes: plans as JSON, and what is made of a plan."""

from scenecc.diagnostics.codes.row import Code


def _plan(*members: str, num_scenes: int = 2) -> str:
    head = ['"scenecc_plan": 1', '"name": "example"', '"description": ""', f'"num_scenes": {num_scenes}']
    rest = [member for member in members if member.split(":")[0] not in {item.split(":")[0] for item in head}]
    given = {member.split(":")[0] for member in members}
    tables = [text for key, text in _TABLES if key not in given]
    return "{" + ", ".join([*head, *tables, *rest]) + "}"


_TABLES = (('"entities"', '"entities": []'), ('"physics"', '"physics": {}'))


def _entity(*, name: str = "ball", scene_idxs: str = '"0:2"', radius: str = "0.1", more: str = "") -> str:
    shape = f'{{"geometry": {{"type": "sphere", "radius": {radius}}}{more}}}'
    return (
        f'{{"name": "{name}", "scene_idxs": {scene_idxs}, "pose": [0, 0, 1, 1, 0, 0, 0], '
        f'"structures": [{{"body_type": "dynamic", "collisions": [{shape}]}}]}}'
    )


_ROOT = '{"name": "base", "body": {"body_type": "link"}}'


def _robot(*links: str) -> str:
    return (
        '{"name": "robot", "scene_idxs": "0:2", "pose": [0, 0, 0, 1, 0, 0, 0], '
        f'"structures": [{{"type": "articulation", "links": [{", ".join(links)}]}}]}}'
    )


def _entities(*entities: str) -> str:
    return '"entities": [' + ", ".join(entities) + "]"


ROWS: tuple[Code, ...] = (
    Code(
        code="SC701",
        severity="error",
        title="a plan is not JSON",
        cause="The text of a plan is cut off or damaged: a plan is read by JSON's own rules, without comments.",
        example='{"scenecc_plan": 1,',
        cure="Make the plan again from its scene: `scenecc emit SCENE --to json -o PLAN.json`.",
    ),
    Code(
        code="SC702",
        severity="error",
        title="not a plan of this version",
        cause="The key `scenecc_plan` says which version of the format a plan is in, and another one would be misread.",
        example='{"scenecc_plan": 99}',
        cure="Make the plan again from its scene with the scenecc that reads it.",
    ),
    Code(
        code="SC703",
        severity="error",
        title="unknown key in a plan",
        cause="A key that is not known would be dropped silently.",
        example=_plan('"physics": {"timestp": 0.01}'),
        cure="Write the key that the hint names, or take it out.",
    ),
    Code(
        code="SC704",
        severity="error",
        title="missing key in a plan",
        cause="Everything that has no default must be there.",
        example=_plan(_entities('{"name": "ball", "scene_idxs": "0:2"}')),
        cure="Add the key that the message names.",
    ),
    Code(
        code="SC705",
        severity="error",
        title="a value of the wrong type in a plan",
        cause="A plan is strict: a string is no number, 1 is not true, and a word must be one of those known.",
        example=_plan(_entities(_entity(radius='"0.1"'))),
        cure="Write the type that the message names.",
    ),
    Code(
        code="SC706",
        severity="error",
        title="the wrong count of values in a plan",
        cause="A vector has its own length, and `per_scene` and `pick` have one item for each scene of the entity.",
        example=_plan(_entities(_entity(radius='{"per_scene": [0.1, 0.2, 0.3]}'))),
        cure="Write as many items as the message names.",
    ),
    Code(
        code="SC707",
        severity="error",
        title="a number out of range in a plan",
        cause="SAPIEN takes negative sizes, zero quaternions and numbers that are not finite, and builds nonsense.",
        example=_plan(_entities(_entity(radius="-0.1"))),
        cure="Write a number in the range that the message names.",
    ),
    Code(
        code="SC708",
        severity="error",
        title="an index outside its table in a plan",
        cause="Shapes name files and materials by their place in the plan's tables, and `pick` names structures so.",
        example=_plan(_entities(_entity(more=', "material": 3'))),
        cure="Add the entry to the table, or name one that is there; indices start at 0.",
    ),
    Code(
        code="SC709",
        severity="error",
        title="scenes that are not there",
        cause="`scene_idxs` are indices from 0 to `num_scenes` - 1, ascending, each once, and at least one; what is "
        "held on to is in all scenes of what holds on.",
        example=_plan(_entities(_entity(scene_idxs="[0, 5]"))),
        cure="Write indices, or a slice such as `0:2`, within `num_scenes`.",
    ),
    Code(
        code="SC710",
        severity="error",
        title="a name twice in a plan",
        cause="Entities, cameras, links and joints, constraints and lights are found by their names.",
        example=_plan(_entities(_entity(), _entity())),
        cure="Rename one of them.",
    ),
    Code(
        code="SC711",
        severity="error",
        title="a file of a plan cannot be found",
        cause="The plan names a file by a uri that leads nowhere here.",
        example=_plan('"files": [{"uri": "nowhere://mug.obj"}]'),
        cure="Write a path relative to the plan, `pkg://PACKAGE/PATH` or `asset://PATH`.",
    ),
    Code(
        code="SC712",
        severity="error",
        title="a plan beyond the limits",
        cause="A plan from a stranger must not exhaust the machine that reads it.",
        example=_plan(num_scenes=100_000_000_000),
        cure="Make the plan smaller, or raise the limit that the message names.",
    ),
    Code(
        code="SC713",
        severity="error",
        title="a key twice in a plan",
        cause="Of two equal keys in one JSON object only the last would count.",
        example='{"scenecc_plan": 1, "name": "a", "name": "b"}',
        cure="Take one of them out.",
    ),
    Code(
        code="SC714",
        severity="error",
        title="links that are no tree in a plan",
        cause="The first link of an articulation is its root; every other one hangs by a joint on a link before it.",
        example=_plan(_entities(_robot(_ROOT, '{"name": "arm", "body": {"body_type": "link"}, "parent": 0}'))),
        cure="Put parents before their children, and give every link but the first a `parent` and a `joint`.",
    ),
    Code(
        code="SC715",
        severity="error",
        title="a name in a plan that nothing has",
        cause="Constraints, lights and cameras hold on to entities and links by their names, and joints that follow "
        "others name these.",
        example=_plan(
            '"constraints": [{"name": "c", "scene_idxs": "0:2", "joint": {"type": "weld"}, '
            '"child": {"entity": "ball"}}]'
        ),
        cure="Write the name of an entity, of one of its links, or of a joint that moves.",
    ),
    Code(
        code="SC716",
        severity="error",
        title="a file of a plan is not what it was",
        cause="A plan has the SHA-256 of every file that a build opens, and of those that such a file names. One of "
        "them was written again since the plan was made, is gone, or is there now and was not.",
        example="$ scenecc build scene.yaml --dry-run -o plan.json && cp other.obj bowl.obj && scenecc build plan.json",
        cure="Put the file back, or make the plan again from its scene.",
    ),
    Code(
        code="SC717",
        severity="warning",
        title="a plan that does not say what a file held",
        cause="The plan was made before plans had hashes, or somebody took the hash out of it: whether the file is "
        "what it was cannot be told.",
        example="$ scenecc validate plan-of-an-older-version.json",
        cure="Make the plan again from its scene: `scenecc emit SCENE --to json -o PLAN.json`.",
    ),
    Code(
        code="SC720",
        severity="error",
        title="a plan that cannot be written as a script",
        cause="A value of the plan has no counterpart in SAPIEN for that type of body, so that a script would drop it.",
        example="$ scenecc emit plan-with-a-damped-static-body.json --to python",
        cure="Take the value out of the plan, or change the type of the body.",
    ),
)

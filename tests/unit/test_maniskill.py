"""What of `scenecc.maniskill` can be told without ManiSkill."""

from __future__ import annotations

import re
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest

import scenecc
from scenecc import SceneError
from scenecc.extras import install_hint


def test_importing_scenecc_maniskill_loads_no_engine_and_no_extra() -> None:
    script = (
        "import sys, scenecc.maniskill\n"
        "heavy = {'sapien', 'torch', 'mani_skill', 'gymnasium'}\n"
        "print(heavy & set(sys.modules))\n"
        "print(callable(scenecc.maniskill.load_into), heavy & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", script], check=True, timeout=60, capture_output=True, text=True)
    assert ran.stdout == "set()\nTrue set()\n"


@pytest.mark.parametrize("missing", ["mani_skill", "torch"])
def test_a_missing_maniskill_gives_an_install_hint(missing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    scene: Any = SimpleNamespace(num_envs=1, sub_scenes=[None])
    with pytest.raises(SceneError, match=re.escape(install_hint("maniskill", "torch"))) as caught:
        scenecc.load_scene({"scenecc": 1, "entities": {}}, scene=scene)
    assert [d.code for d in caught.value.diagnostics] == ["SC805"]
    assert caught.value.at_fault == "machine"


@pytest.mark.parametrize("scene", [SimpleNamespace(num_envs=1), object()])
def test_an_invalid_environment_scene_is_refused(scene: Any) -> None:
    """As a `sapien.Scene`, or the environment itself."""
    from scenecc.maniskill import load_into

    for load in (lambda: scenecc.load_scene({"scenecc": 1}, scene=scene), lambda: load_into(scene, {"scenecc": 1})):
        with pytest.raises(TypeError, match=f"`env.unwrapped.scene`, not {type(scene).__name__}; "):
            load()


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("load_into", {"audit": "full"}, r"load_into\(\): audit must be True or False, not 'full'"),
        ("load_into", {"seed": "a"}, r"load_into\(\): seed must be an integer, not 'a'"),
        ("load_into", {"backend": "cuda"}, r"load_into\(\) has no argument `backend`; .* GPU use `scenecc\.maniskill`"),
        (
            "load_into",
            {"num_scenes": 2},
            r"load_into\(\) has no argument `num_scenes`; the nearest here: .* others \(its help lists all\)",
        ),
        ("load_scene", {"audit": "full"}, r"load_scene\(\): audit must be True or False, not 'full'"),
        ("load_scene", {"backend": "cuda"}, r"load_scene\(\) has no argument `backend`; .* use `scenecc\.maniskill`"),
    ],
)
def test_a_wrong_argument_names_the_function_that_was_called(name: str, options: dict[str, Any], message: str) -> None:
    from scenecc.maniskill import load_into

    scene: Any = SimpleNamespace(num_envs=1, sub_scenes=[None])
    calls: dict[str, Any] = {
        "load_into": lambda: load_into(scene, {"scenecc": 1}, **options),
        "load_scene": lambda: scenecc.load_scene({"scenecc": 1}, **options),
    }
    with pytest.raises(TypeError, match=f"^{message}"):
        calls[name]()


def test_a_missing_environment_scene_is_refused() -> None:
    """Before ManiSkill made it, `self.scene` is None."""
    from scenecc.maniskill import load_into

    nothing: Any = None
    with pytest.raises(TypeError, match="`scene` must be a ManiSkill environment's scene"):
        load_into(nothing, {"scenecc": 1})


def test_sim_config_without_torch_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.maniskill import sim_config

    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(SceneError, match="cannot be used"):
        sim_config({"scenecc": 1})


def test_an_unknown_name_of_scenecc_maniskill_raises() -> None:
    import scenecc.maniskill

    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = scenecc.maniskill.nothing  # pyright: ignore[reportAttributeAccessIssue]

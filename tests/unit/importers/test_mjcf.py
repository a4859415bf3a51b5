"""MJCF files as scenes: what is copied, and what the certificate says."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from scenecc.errors import SceneError
from scenecc.importers.import_scene import import_scene

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("mujoco")

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
ROCK = """<mujoco><asset><mesh name="rock" file="rock.obj"/></asset>
<worldbody><geom type="mesh" mesh="rock"/></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("in", "out", "private"):
        (tmp_path / name).mkdir()
    (tmp_path / "private/key.mtl").write_text("newmtl private\n")
    return tmp_path


def test_no_file_outside_the_folder_is_read_or_copied(folder: Path) -> None:
    (folder / "in/rock.obj").write_text("mtllib ../private/key.mtl\n" + TETRAHEDRON)
    (folder / "in/rock.xml").write_text(ROCK)
    with pytest.raises(SceneError) as caught:
        import_scene(folder / "in/rock.xml", folder / "out/rock.yaml")
    assert any("key.mtl" in one.message for one in caught.value.diagnostics)
    assert not list((folder / "out").iterdir())
    made = import_scene(folder / "in/rock.xml", folder / "out/rock.yaml", asset_roots=[folder / "private"])
    assert any(path.name == "key.mtl" for path in made.paths)


def test_a_file_without_a_moving_body_is_compared_all_the_same(folder: Path) -> None:
    (folder / "in/rock.obj").write_text(TETRAHEDRON)
    (folder / "in/rock.xml").write_text(ROCK)
    made = import_scene(folder / "in/rock.xml", folder / "out/rock.yaml")
    assert made.certificate.lines() == ["built 1 body; those that move weigh 0 kg", "compared with MuJoCo: 0 bodies"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"file": 3}, "import_scene(): file must be a string or a path, not 3"),
        ({"output": None}, "import_scene(): output must be a string or a path, not None"),
        ({"allow": 3}, "import_scene(): allow must be names"),
        ({"allow": [3]}, "import_scene(): allow must be names"),
    ],
)
def test_a_wrong_argument_is_one_error_that_names_it(folder: Path, arguments: dict[str, Any], words: str) -> None:
    whole = {"file": folder / "in/rock.xml", "output": folder / "out/rock.yaml", **arguments}
    with pytest.raises(TypeError) as caught:
        import_scene(**whole)
    assert words in str(caught.value)

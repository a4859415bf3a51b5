"""Small scenes from strangers that ask for very many robots, or for large files again and again."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest
from plugins.nightly import assert_took

import scenecc
from scenecc.robots import files

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic

SHAPE = '<collision><geometry><sphere radius="1"/></geometry></collision>'


def validated(folder: Path, entities: str, limits: dict[str, int] | None = None) -> list[Diagnostic]:
    path = folder / "s.yaml"
    path.write_text(f"scenecc: 1\nentities:\n  {entities}\n")
    return [one for one in scenecc.validate(path, limits=limits) if one.severity == "error"]


@pytest.mark.parametrize("key", ["urdf", "mjcf"])
def test_too_many_robots_are_refused_before_lowering(key: str, tmp_path: Path) -> None:
    body = f'<robot name="r"><link name="a">{SHAPE * 4_000}</link></robot>'
    if key == "mjcf":
        body = "<mujoco><worldbody><body>" + '<geom size="1"/>' * 4_000 + "</body></worldbody></mujoco>"
    (tmp_path / "r.xml").write_text(body)
    start = time.process_time()
    (found,) = validated(tmp_path, f"r: {{{key}: r.xml, repeat: {{i: {{count: 20000}}}}}}", {"objects": 50_000})
    assert (found.code, found.line) == ("SC604", 3)
    assert found.hint is not None
    assert "--limit objects=" in found.hint
    assert_took(time.process_time() - start, most=60)


def test_each_alternative_robot_file_counts_towards_the_budget(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="a">{SHAPE}</link></robot>')
    names = ", ".join("./" * i + "r.urdf" for i in range(10))
    assert not validated(tmp_path, f"r: {{urdf: {{choice: [{names}]}}}}", {"objects": 20})
    (found,) = validated(tmp_path, f"r: {{urdf: {{choice: [{names}]}}}}", {"objects": 19})
    assert (found.code, found.line) == ("SC604", 3)


FILES = {
    "bytes": SHAPE + "</link><!--" + "x" * (4 * 2**20) + "-->",
    "elements": SHAPE + "</link>" + "<a/>" * 25_000,
    "mistakes": "<collision/>" * 99_000 + "</link>",
}


@pytest.mark.parametrize("name", FILES)
def test_a_large_robot_file_at_many_scales_exceeds_the_budget(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "MAX_READ_MEMORY", files.MAX_READ_MEMORY // 8)
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="a">{FILES[name]}</robot>')
    start = time.process_time()
    found = validated(tmp_path, "r: {urdf: r.urdf, scale: '${1 + i / 1000}', repeat: {i: {count: 2000}}}")
    assert found[-1].code == ("SC016" if name == "mistakes" else "SC452")
    assert_took(time.process_time() - start, most=60)


LESS_MEMORY = """
from scenecc.robots import files
files.MAX_READ_MEMORY //= 8
import sys
from scenecc.cli import main
sys.argv[1:] = ["validate", "s.yaml"]
main()
"""


def test_a_large_file_with_many_includes_exceeds_the_budget(tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text("<x><!--" + "x" * (15 * 2**20) + "--></x>")
    for i in range(100):
        (tmp_path / f"{i}.xml").write_text(
            '<mujoco><include file="in.xml"/><worldbody><body><geom size="1"/></body></worldbody></mujoco>'
        )
    (tmp_path / "s.yaml").write_text("scenecc: 1\nentities:\n  r: {mjcf: '${i}.xml', repeat: {i: {count: 100}}}\n")
    answer = subprocess.run(
        [sys.executable, "-c", LESS_MEMORY],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30)),
    )
    assert answer.returncode == 1, answer.stderr
    assert "SC452" in answer.stdout + answer.stderr

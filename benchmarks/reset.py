"""Resets of many scenes in which much is drawn anew, against those that draw poses alone and against a rebuild."""

from __future__ import annotations

import io
import time

from benchmarks.paired import Row, Side, alternating, best, ratios

SCENES = 1024
OVER_POSES = f"reset of {SCENES} scenes: masses, a friction, colours, lights, a camera / poses alone"
OVER_BUILD = "the same / text to live scenes"

_TEXT = """
scenecc: 1
environment: {{ambient_light: {ambient}}}
lights:
  sun: {{type: directional, direction: {direction}, color: {light}, shadow: true}}
  lamp: {{type: point, position: {position}, color: [1, 1, 1]}}
cameras: {{eye: {{pose: {{p: {eye}, look_at: [0, 0, 0.2]}}, width: 64, height: 64}}}}
materials: {{rubber: {{physical: {{static_friction: {friction}}}}}}}
entities:
  ground: {{body_type: static, shapes: [{{type: plane}}]}}
  table:
    body_type: static
    pose: [0, 0, 0.1]
    color: {color}
    shapes: [{{type: box, half_size: [0.6, 0.6, 0.1]}}]
  cube:
    repeat: {{i: {{count: 8}}}}
    pose: {{p: {{uniform: [[-0.5, -0.5, 0.25], [0.5, 0.5, 0.5]]}}, q: uniform}}
    mass: {mass}
    color: {color}
    material: rubber
    shapes: [{{type: box, half_size: [0.05, 0.05, 0.05]}}]
"""

_POSES = {
    "ambient": "[0.3, 0.3, 0.3]",
    "direction": "[0.1, 0, -1]",
    "light": "[1, 1, 1]",
    "position": "[0, 0, 1]",
    "eye": "[-1.5, 0, 1]",
    "friction": "0.6",
    "color": "'#808080'",
    "mass": "0.5",
}

_EVERYTHING = {
    "ambient": "{uniform: [[0.1, 0.1, 0.1], [0.5, 0.5, 0.5]]}",
    "direction": "[{uniform: [-0.5, 0.5]}, 0, -1]",
    "light": "{uniform: [[0.5, 0.5, 0.5], [2, 2, 2]]}",
    "position": "[{uniform: [-1, 1]}, 0, 1]",
    "eye": "[{uniform: [-2, -1]}, 0, 1]",
    "friction": "{uniform: [0.5, 1]}",
    "color": "{uniform: [[0, 0, 0], [1, 1, 1]]}",
    "mass": "{uniform: [0.1, 1]}",
}


def run(repetitions: int) -> list[Row]:
    """Each side has its batch alone in the process: PhysX tells every scene there is of each friction that is set."""
    from scenecc import load_scene
    from scenecc.backends.sapien.engine import render_problem

    if (problem := render_problem()) is not None:
        return [Row("reset", what, (), note=f"no device renders: {problem}") for what in (OVER_POSES, OVER_BUILD)]
    drawn = _TEXT.format(**_EVERYTHING)

    def resetting(text: str) -> Side:
        def side() -> float:
            with load_scene(io.StringIO(text), num_scenes=SCENES, render=True) as batch:
                batch.reset(seed=1)
                batch.step()
                started = time.perf_counter()
                batch.reset(seed=2)
                return time.perf_counter() - started

        return side

    def build() -> float:
        started = time.perf_counter()
        batch = load_scene(io.StringIO(drawn), num_scenes=SCENES, render=True)
        seconds = time.perf_counter() - started
        batch.close()
        return seconds

    rounds = alternating([resetting(drawn), resetting(_TEXT.format(**_POSES)), build], repetitions)
    poses, rebuild = (f"{best(rounds, 0)} / {best(rounds, other)}" for other in (1, 2))
    return [
        Row("reset", OVER_POSES, ratios(rounds, 0, 1), 2.0, None, poses),
        Row("reset", OVER_BUILD, ratios(rounds, 0, 2), 0.5, None, rebuild),
    ]

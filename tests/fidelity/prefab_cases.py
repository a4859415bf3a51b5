"""Parameters to give the prefabs that ship."""

from __future__ import annotations

from pathlib import Path
from typing import Any

PREFABS = Path(__file__).resolve().parents[2] / "scenecc" / "prefabs"
ROBOTS = frozenset({"table_scene"})
"""Prefabs of robots, whose files come with ManiSkill: tests/maniskill/test_table_scene.py."""

NAMES = sorted(file.stem for file in PREFABS.glob("*.yaml") if "." not in file.stem and file.stem not in ROBOTS)


def srgb(text: str) -> list[float]:
    """Linear light of "#rrggbb" or "#rrggbbaa" (IEC 61966-2-1)."""
    parts = [int(text[i : i + 2], 16) / 255 for i in range(1, len(text), 2)]
    return [*(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts[:3]), *parts[3:]]


OURS: dict[str, dict[str, Any]] = {
    "cube": {"half_size": 0.02, "color": [1, 0, 0, 1]},
    "box": {"half_sizes": [0.02, 0.02, 0.02], "color": [1, 0, 0, 1]},
    "sphere": {"radius": 0.02, "color": [12 / 255, 42 / 255, 160 / 255, 1]},
    "cylinder": {"radius": 0.02, "half_length": 0.02, "color": [1, 0, 0, 1]},
    "red_white_target": {"radius": 0.1, "thickness": 0.01},
    "twocolor_peg": {
        "length": 0.1,
        "width": 0.02,
        "color_1": srgb("#dc0c0c"),
        "color_2": srgb("#002cc1"),
    },
    "fourcolor_peg": {"length": 0.1, "width": 0.02},
    "colorful_cube": {"half_size": 0.02, "color": [1, 0, 0, 1]},
    "table": {},
    "bin": {
        "length": 0.4,
        "width": 0.3,
        "height": 0.15,
        "thickness": 0.01,
        "color": srgb("#3a6ea5"),
    },
    "shelf": {
        "width": 0.8,
        "depth": 0.3,
        "height": 1.2,
        "thickness": 0.02,
        "boards": 4,
        "color": srgb("#b08d57"),
    },
    "stairs": {"steps": 5, "rise": 0.15, "run": 0.28, "width": 1, "color": srgb("#8d8d8d")},
}
"""Our defaults where ManiSkill and the tutorial have none."""

ALIKE: dict[str, dict[str, Any]] = {
    "table_workspace": {"visual": "boxes"},
    "random_clutter": {"target": "floor", "n": 4},
    "rope": {"pieces": 3},
}
"""What makes a prefab the same whatever packages are installed, and parameters without a default."""

STATIC = frozenset(("bin", "shelf", "stairs", "ground"))

CASES: list[tuple[str, dict[str, Any]]] = [
    *((name, {}) for name in OURS),
    ("cube", {"half_size": 0.07, "color": [0.1, 0.2, 0.3, 0.4], "body_type": "kinematic"}),
    ("cube", {"half_size": 0.013, "color": "#0c2aa080", "body_type": "static", "add_collision": False}),
    ("box", {"half_sizes": [0.03, 0.11, 0.017], "color": [0.5, 0.6, 0.7]}),
    (
        "box",
        {"half_sizes": [0.1, 0.1, 0.001], "color": [0, 1, 0, 0.5], "body_type": "kinematic", "add_collision": False},
    ),
    ("sphere", {"radius": 0.0371, "color": [0, 0.5, 1, 1]}),
    ("sphere", {"radius": 0.2, "body_type": "static"}),
    ("cylinder", {"radius": 0.05, "half_length": 0.013, "color": [1, 1, 0, 1]}),
    ("cylinder", {"radius": 0.011, "half_length": 0.17, "body_type": "kinematic"}),
    ("red_white_target", {"radius": 0.073, "thickness": 0.031}),
    ("red_white_target", {"radius": 0.1, "thickness": 1e-5, "body_type": "kinematic", "add_collision": False}),
    ("red_white_target", {"radius": 0.25, "thickness": 0.04, "body_type": "static"}),
    ("twocolor_peg", {"length": 0.12, "width": 0.025, "color_1": [0.1, 0.2, 0.3, 1], "color_2": [1, 0.5, 0, 0.3]}),
    ("twocolor_peg", {"length": 0.05, "width": 0.01, "body_type": "static", "add_collision": False}),
    ("fourcolor_peg", {"length": 0.09, "width": 0.031, "color_1": [0, 0, 0, 1], "color_4": [0.3, 0.3, 0.3, 1]}),
    ("fourcolor_peg", {"length": 0.12, "width": 0.025, "color_2": [1, 1, 0, 1], "body_type": "kinematic"}),
    ("colorful_cube", {"half_size": 0.04, "color": [0.2, 0.9, 0.4, 1]}),
    ("colorful_cube", {"half_size": 0.033, "body_type": "kinematic"}),
    ("colorful_cube", {"half_size": 0.033, "body_type": "kinematic", "add_collision": False}),
    ("table", {"size": 0.7, "height": 0.45, "thickness": 0.03, "color": [0.2, 0.3, 0.4, 0.5]}),
    ("table", {"size": 1.3, "height": 0.3}),
    ("bin", {"length": 0.21, "width": 0.33, "height": 0.17, "thickness": 0.007, "body_type": "dynamic"}),
    ("shelf", {"boards": 2, "back": False, "thickness": 0.031}),
    ("shelf", {"width": 0.5, "depth": 0.2, "height": 0.9, "boards": 7, "body_type": "dynamic"}),
    ("stairs", {"steps": 1}),
    ("stairs", {"steps": 11, "rise": 0.017, "run": 0.031, "width": 0.3, "body_type": "kinematic"}),
]

VARIED: dict[str, dict[str, list[Any]]] = {
    "ground": {
        "altitude": [-0.5, 0.25],
        "floor_width": [10, 20],
        "floor_length": [5, 8],
        "xy_origin": [[0, 0], [1, 2]],
        "texture_square_len": [1, 4],
    },
    "cube": {"half_size": [0.02, 0.07], "color": [[0, 0, 1], [0, 1, 0, 0.5]]},
    "box": {"half_sizes": [[0.02, 0.03, 0.04], [0.04, 0.05, 0.01]], "color": ["#ff0000", "#00ff00"]},
    "sphere": {"radius": [0.02, 0.05], "color": [[0, 0, 1], [0, 1, 0]]},
    "cylinder": {"radius": [0.02, 0.05], "half_length": [0.1, 0.2], "color": [[0, 0, 1], [0, 1, 0]]},
    "red_white_target": {"radius": [0.1, 0.2], "thickness": [0.01, 0.03]},
    "twocolor_peg": {
        "length": [0.1, 0.2],
        "width": [0.02, 0.03],
        "color_1": [[0, 0, 1], [0, 1, 0]],
        "color_2": [[0, 0, 1], [0, 1, 0]],
    },
    "fourcolor_peg": {
        "length": [0.1, 0.2],
        "width": [0.02, 0.03],
        **{f"color_{i}": [[0, 0, 1], [0, 1, 0]] for i in range(1, 5)},
    },
    "colorful_cube": {"half_size": [0.02, 0.07], "color": [[0, 0, 1], [0, 1, 0]]},
    "table": {"size": [1, 0.7], "height": [1, 0.6], "thickness": [0.1, 0.05], "color": [[0, 0, 1], [0, 1, 0]]},
    "table_workspace": {"color": [[0, 0, 1], [0, 1, 0]], "floor_width": [10, 20], "table_p": [[0, 0, -1], [0.1, 0, 0]]},
    "bin": {
        "length": [0.4, 0.5],
        "width": [0.3, 0.2],
        "height": [0.15, 0.2],
        "thickness": [0.01, 0.02],
        "color": [[0, 0, 1], [0, 1, 0]],
    },
    "shelf": {
        "width": [0.8, 0.9],
        "depth": [0.3, 0.2],
        "height": [1.2, 0.9],
        "thickness": [0.02, 0.03],
        "color": [[0, 0, 1], [0, 1, 0]],
    },
    "stairs": {"rise": [0.15, 0.1], "run": [0.28, 0.3], "width": [1, 2], "color": [[0, 0, 1], [0, 1, 0]]},
    "rope": {
        "length": [1, 0.8],
        "radius": [0.01, 0.015],
        "density": [1000, 500],
        "stiffness": [0, 1000],
        "bending": [0, 100],
        "drag": [0, 0.5],
        "color": [[0, 0, 1], [0, 1, 0]],
    },
    "random_clutter": {
        "length": [0.4, 1],
        "width": [0.4, 0.2],
        "min_size": [0.015, 0.01],
        "max_size": [0.035, 0.05],
        "density": [1000, 500],
    },
}
"""Two values of every parameter that may differ from scene to scene; of the others the structure depends."""


def label(value: Any) -> str:
    """Of a test: the name of a prefab, and of the parameters that are given."""
    return value if isinstance(value, str) else ",".join(map(str, value)) or "defaults"

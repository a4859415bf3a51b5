"""Options of `scenecc render`, under the names of the arguments of `scenecc.render_scene`."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Literal

import typer

from scenecc.cli.completion import complete_entity
from scenecc.cli.options import Camera, at_least, quote_text

_SIZE: Final = re.compile(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})")


What = Literal["color", "depth", "segmentation", "normal"]
Preset = Literal["studio", "plain", "dark"]
View = Literal["iso", "front", "back", "left", "right", "top", "bottom"]
Shader = Literal["default", "minimal", "trivial", "rt", "shadow_catcher"]


def point(text: str | tuple[float, float, float]) -> tuple[float, float, float]:
    """Parses `1,0.5,2`. Raises typer.BadParameter for anything but three numbers."""
    if not isinstance(text, str):
        return text
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{quote_text(text)} must be X,Y,Z in metres, such as 1,0.5,2") from None
    return x, y, z


def parse_size(text: str) -> tuple[int, int]:
    """Parses `640x480`. Raises typer.BadParameter for anything else."""
    from scenecc.plan.schema import PIXEL_BOUNDS

    found, most = _SIZE.fullmatch(text), int(PIXEL_BOUNDS.high)
    size = (int(found[1]), int(found[2])) if found else (0, 0)
    if not found or max(size) > most:
        raise typer.BadParameter(
            f"{quote_text(text)} must be WIDTHxHEIGHT, each from 1 to {most}, such as 640x480", param_hint="'--size'"
        )
    return size


Focus = Annotated[
    str | None,
    typer.Option(
        "--focus",
        metavar="ENTITY",
        help="Point the camera at this entity or ENTITY/LINK.",
        show_default="everything that moves",
        autocompletion=complete_entity,
    ),
]
Eye = Annotated[
    Any,
    typer.Option("--eye", metavar="X,Y,Z", parser=point, help="Camera position [m].", show_default="fits the view"),
]
LookAt = Annotated[
    Any,
    typer.Option(
        "--look-at",
        metavar="X,Y,Z",
        parser=point,
        help="Point that the camera looks at [m].",
        show_default="centre of the view",
    ),
]
ViewOption = Annotated[
    View | None,
    typer.Option(
        "--view", help="Side to look from; front is +x, left is +y.", show_default="iso, or where nothing is in the way"
    ),
]
Zoom = Annotated[
    float | None,
    typer.Option("--zoom", metavar="FACTOR", help="Magnification of the view, 0.1 to 100.", show_default="1"),
]
Samples = Annotated[
    int | None,
    typer.Option(
        "--samples",
        metavar="N",
        parser=at_least(0),
        help="Samples per pixel, 1 to 256, for smooth edges.",
        show_default="4; 1 with --camera; 32 for ray tracing",
    ),
]
ShaderOption = Annotated[
    Shader | None, typer.Option("--shader", help="Shader pack; rt traces rays.", show_default="the camera's")
]
PresetOption = Annotated[
    Preset | None,
    typer.Option(
        "--preset",
        help="Light rig and background, overriding the file.",
        show_default="studio if the file has no lights",
    ),
]
Background = Annotated[
    str | None,
    typer.Option("--background", metavar="COLOR", help="'#rrggbb' or a CSS colour name.", show_default="the preset's"),
]
Ground = Annotated[bool, typer.Option("--ground", help="Draw a grid on the ground as a scale.")]
Labels = Annotated[bool, typer.Option("--labels", help="Draw the names of entities.")]
Frames = Annotated[bool, typer.Option("--frames", help="Draw the axes of entities and links.")]
Contacts = Annotated[bool, typer.Option("--contacts", help="Draw contact points and forces of the last step.")]
WhatOption = Annotated[What, typer.Option("--what", help="Content of the picture.")]
Legend = Annotated[bool, typer.Option("--legend", help="Depth or segmentation in colours with a legend.")]
Scene = Annotated[
    str | None,
    typer.Option(
        "--scene", metavar="IDXS", help="Scene to render, or several (0:4 or 0,2 or ::2) on one contact sheet."
    ),
]
Grid = Annotated[bool, typer.Option("--grid", help="Render all scenes on one contact sheet, labelled by index.")]
Size = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Size of each picture [px], overriding the camera."),
]
Hidden = Annotated[
    bool | None,
    typer.Option(
        "--hidden/--no-hidden", help="Show objects that are hidden from sensors.", show_default="only without --camera"
    ),
]

PICTURE_OPTIONS: Final[dict[str, tuple[Any, Any]]] = {
    "camera": (Camera, None),
    "focus": (Focus, None),
    "eye": (Eye, None),
    "look_at": (LookAt, None),
    "view": (ViewOption, None),
    "zoom": (Zoom, None),
    "scenes": (Scene, None),
    "grid": (Grid, False),
    "size": (Size, None),
    "what": (WhatOption, "color"),
    "legend": (Legend, False),
    "samples": (Samples, None),
    "shader": (ShaderOption, None),
    "preset": (PresetOption, None),
    "background": (Background, None),
    "ground": (Ground, False),
    "labels": (Labels, False),
    "frames": (Frames, False),
    "contacts": (Contacts, False),
    "hidden": (Hidden, None),
}
"""Options of pictures: argument → (option, default)."""


def picture_choices(others: dict[str, Any], **further: Any) -> dict[str, Any]:
    """Returns the arguments of `render_scene` from these options and `further` ones.

    Raises typer.BadParameter if the options do not fit together.
    """
    from scenecc.render.choices import ChoiceError, check_choices

    size = others["size"]
    choices = {**others, "size": None if size is None else parse_size(size), **further}
    try:
        check_choices(choices)
    except ChoiceError as error:
        option = f"'--{error.argument.replace('_', '-')}'"
        raise typer.BadParameter(error.problem, param_hint=option) from None
    return choices

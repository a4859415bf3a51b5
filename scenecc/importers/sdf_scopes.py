"""The worlds and models of an SDF file with everything that they include."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from scenecc.importers.numbers import Names
from scenecc.importers.sdf_files import find_model
from scenecc.importers.sdf_frames import MODEL, SEPARATOR, WORLD, Scope
from scenecc.importers.sdf_xml import read_file, text_of

if TYPE_CHECKING:
    from scenecc.importers.sdf_xml import SdfFile, SourceElement

_MAX_DEPTH: Final = 20
_MAX_INCLUDES: Final = 2000


class ScopeReader:
    """Reads scopes.

    Args:
        file: the file that is imported.

    Attributes:
        robots: URDFs that are included: name, file, the element, whether it is static.
    """

    def __init__(self, file: SdfFile) -> None:
        self._top = file
        self._count = 0
        self._names: dict[int, Names] = {}
        self.robots: list[tuple[str, Path, SourceElement]] = []

    def world(self, element: SourceElement) -> Scope:
        """The scope of a <world>, or of an <sdf> without one."""
        file = self._top
        scope = Scope(file, element, element.attributes.get("name", "world"), WORLD, element, file)
        self._fill(scope, (file.path.resolve(),))
        return scope

    def _fill(self, scope: Scope, chain: tuple[Path, ...]) -> None:
        for child in scope.element.children:
            if child.tag == "include":
                self._include(child, scope, chain)
            elif child.tag == "model":
                self._add(self._model(child, scope), scope, chain)
            elif child.tag in {"link", "joint", "frame"}:
                table = {"link": scope.links, "joint": scope.joints, "frame": scope.frames}[child.tag]
                name = child.attributes.get("name", "")
                # Models that older versions flattened have links called `MODEL::LINK`.
                is_flat = scope.file.is_before(1, 8)
                if not name or name in table or (SEPARATOR in name and not is_flat):
                    what = "is used twice" if name in table else "is not a name"
                    scope.file.error(f"`{name[:80]}` {what}, of a <{child.tag}> in `{scope.name}`", child)
                    continue
                table[name] = child

    def _model(self, element: SourceElement, scope: Scope) -> Scope:
        name = element.attributes.get("name", "")
        is_static = scope.is_static or scope.file.flag(element, "static", default=False)
        frame = element.attributes.get("placement_frame", "")
        return Scope(scope.file, element, name, MODEL, element, scope.file, frame, is_static)

    def _add(self, model: Scope, scope: Scope, chain: tuple[Path, ...]) -> None:
        if not model.name or SEPARATOR in model.name or len(chain) > _MAX_DEPTH + 1:
            what = "is not a name of a model" if len(chain) <= _MAX_DEPTH + 1 else "is nested too deep"
            scope.file.error(f"`{model.name[:80]}` {what}", model.placing)
            return
        if model.name in scope.models:
            # Drake and Gazebo refuse it; worlds that were saved by older versions have it.
            names = self._names.setdefault(id(scope), Names())
            free = names.new(model.name)
            while free in scope.models:
                free = names.new(model.name)
            scope.file.lose("names", f"a second model `{model.name}` is called `{free}`", model.placing)
            model = replace(model, name=free)
        scope.models[model.name] = model
        self._fill(model, chain)

    def _include(self, element: SourceElement, scope: Scope, chain: tuple[Path, ...]) -> None:
        self._count += 1
        uri, file = text_of(element, "uri"), scope.file
        found = find_model(uri, file)
        if isinstance(found, str):
            file.lose("models", f"<include>: {found}", element)
            scope.missing.add(text_of(element, "name") or Path(uri).stem)
            return
        if found in chain or len(chain) > _MAX_DEPTH or self._count > _MAX_INCLUDES:
            why = "includes itself" if found in chain else "includes too many files"
            file.error(f"`{uri[:80]}` {why}", element)
            return
        if found.suffix.lower() == ".urdf":
            self.robots.append((text_of(element, "name") or found.stem, found, element))
            return
        loaded = read_file(found, file.context, file.losses)
        if loaded is None:
            return
        inner, root = loaded
        models = list(root.all("model"))
        if len(models) != 1:
            kinds = ", ".join(dict.fromkeys(f"<{child.tag}>" for child in root.children)) or "nothing"
            file.lose("models", f"`{uri[:80]}` holds {kinds} and not one model", element)
            return
        name = text_of(element, "name") or models[0].attributes.get("name", "")
        static = file.flag(element, "static", default=inner.flag(models[0], "static", default=False))
        posed = element.find("pose") is not None
        frame = text_of(element, "placement_frame") or models[0].attributes.get("placement_frame", "")
        self._add(
            Scope(
                inner,
                models[0],
                name,
                MODEL,
                element if posed else models[0],
                file if posed else inner,
                frame,
                scope.is_static or static,
                element.attributes.get("merge") in {"true", "1"},
            ),
            scope,
            (*chain, found),
        )

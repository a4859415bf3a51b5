"""What a batch reads and sets, in PyTorch's tensors."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from inspect import ismethod
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from scenecc.backends.sapien.contacts import Contacts
from scenecc.backends.sapien.objects import ComponentBatch, NamedObjects

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray


class TensorView:
    """An object of a batch with tensors where it has arrays: those it gives are copies, those it takes are read.

    It has the attributes and methods of the object; strings and SAPIEN's objects are what they are there. Tensors are
    on the CPU.
    """

    def __init__(self, viewed: object) -> None:
        try:
            torch = import_module("torch")
        except ImportError as error:
            raise ImportError("tensors need PyTorch: pip install torch") from error
        vars(self).update(_viewed=viewed, _torch=torch)

    def __getattr__(self, name: str) -> Any:
        return self._convert(getattr(self._viewed, name))

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._viewed, name, self._to_array(value))

    def __dir__(self) -> list[str]:
        return dir(self._viewed)

    def __len__(self) -> int:
        return len(self._viewed)

    def __repr__(self) -> str:
        return f"<tensors of {self._viewed!r}>"

    def _convert(self, found: Any) -> Any:
        if isinstance(found, np.ndarray):
            array = cast("NDArray[Any]", found)
            return array if array.dtype.kind == "U" else self._torch.tensor(array)
        if isinstance(found, ComponentBatch):
            return TensorView(found)
        if isinstance(found, NamedObjects):
            return cast("NamedObjects[Any]", found).converted(self._convert)
        if isinstance(found, dict):
            return {key: self._convert(value) for key, value in cast("dict[str, Any]", found).items()}
        if isinstance(found, Contacts):
            return Contacts(*map(self._convert, found))
        return partial(self._call, found) if ismethod(found) else found

    def _call(self, method: Callable[..., Any], *arguments: object, **named: object) -> Any:
        named = {key: self._to_array(value) for key, value in named.items()}
        return self._convert(method(*map(self._to_array, arguments), **named))

    def _to_array(self, value: Any) -> Any:
        return value.detach().cpu().numpy() if isinstance(value, self._torch.Tensor) else value

"""Whether a document is to be expanded."""

from __future__ import annotations

import pytest

from scenecc.diagnostics import Sink
from scenecc.expand.needs import needs_expansion
from scenecc.source import read_text

PLAIN = [
    "entities: {a: {mass: 1, shapes: [{type: box, half_size: [1, 1, 1]}]}}",
    "# ${not an expression}: a comment\nentities: {cube: {mass: 1}}",
    "description: repeat after me, if you use it\nentities: {a: {mass: {uniform: [1, 2]}}}",
    "x-note: {use: nothing, if: never}\nentities: {}",
    r'description: "a \"quoted\" text"',
    "entities: {use: {mass: 1}, if: {mass: 1}}",
    "entities: {repeat: {mass: 1}}\nmaterials: {repeat: {visual: {base_color_texture: {address_mode: repeat}}}}",
    "entities: {a: {visuals: [{type: tiled_plane, texture_repeat: [1, 2]}]}}",
    "entities: {a: {x-note: {repeat: {i: [1]}}, shapes: [{x-note: [{repeat: 1}], type: box}]}}",
]
EXPANDED = [
    "params: {}",
    "draws: {}",
    "include: []",
    "entities: {a: {mass: '${1}'}}",
    "entities: {a: {if: true}}",
    "entities: {a: {use: b.yaml}}",
    "entities: {a: {repeat: {i: [1]}}}",
    "entities: {a: {shapes: [{repeat: {i: [1]}, type: box}]}}",
    "entities: {a: {variants: [{shapes: [{repeat: {i: [1]}, type: box}]}]}}",
    'entities: {a: {material: "\\x24{m}"}}',
    'entities: {a: {"r\\x65peat": {i: [1]}}}',
    'entities: {a: {material: "$\\\n  {m}"}}',
    "x: &a {repeat: {i: [1]}}\nentities: {a: {<<: *a}}",
]


@pytest.mark.parametrize(("text", "needed"), [*((text, False) for text in PLAIN), *((text, True) for text in EXPANDED)])
def test_what_needs_it(text: str, *, needed: bool) -> None:
    document = read_text("scenecc: 1\n" + text, "s.yaml", Sink())
    assert document is not None
    found = needs_expansion(document.data, document.text)
    # What is not looked through may be thought to need it.
    assert found is needed or (not needed and "${" in text)
    assert needs_expansion(document.data, None) is needed

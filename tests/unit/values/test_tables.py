"""Tables that must have a row for each form or node: one that was added must not be forgotten in them."""

from __future__ import annotations

import json
from typing import Any

import pytest
from pydantic import TypeAdapter

from scenecc.plan import recipe_shape
from scenecc.spec.draws import Draw
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.schema import json_schema
from scenecc.values import evaluate, forms, support_rules
from scenecc.values.nodes import NODES


@pytest.mark.parametrize(
    "table",
    [evaluate._TABLE, support_rules.TABLE, recipe_shape._TABLE],
    ids=["evaluate", "support_rules", "recipe_shape"],
)
def test_every_node_has_a_row(table: Any) -> None:
    assert set(table) == set(NODES)


def test_every_form_has_a_key() -> None:
    keyed = {*forms.LISTED.values(), *forms.DRAWN.values()}
    # A map by scene has the key of the list, and the others have none.
    assert keyed | {forms.SceneMap, forms.RandomRotation, forms.Vector} == set(forms.Form.__args__)
    assert set(VARIATION_FORMS) == {*forms.LISTED, *forms.DRAWN}


@pytest.mark.parametrize("key", sorted(VARIATION_FORMS))
def test_every_form_is_read_and_published(key: str) -> None:
    read = TypeAdapter(Draw).validate_python({key: [1, 2]})
    assert type(read) is {**forms.LISTED, **forms.DRAWN}[key]
    assert f'"{key}"' in json.dumps(json_schema())

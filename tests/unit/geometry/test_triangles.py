"""Parts of a mesh as one."""

import numpy as np
import pytest

from scenecc.geometry.ply import encode_parts, encode_ply
from scenecc.geometry.triangles import join_parts

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32)
FACE = np.array([(0, 1, 2)], np.uint32)


def test_joined_parts_keep_their_corners() -> None:
    parts = [(CORNERS, FACE), (CORNERS[:0], FACE[:0]), (CORNERS + 2, FACE[:, ::-1])]
    vertices, faces = join_parts(parts)
    assert vertices[faces].tolist() == [CORNERS.tolist(), (CORNERS[::-1] + 2).tolist()]
    assert encode_parts(parts) == encode_ply(vertices, faces)


def test_a_ply_needs_a_vertex() -> None:
    with pytest.raises(ValueError, match="no part has a vertex"):
        encode_parts([(CORNERS[:0], FACE[:0])])

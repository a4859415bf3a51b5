"""Numbers, vectors and texts of the language."""

import math
from typing import Annotated

from pydantic import Field, Strict

LARGEST = 3.4028234663852886e38
SMALLEST = 1.1754943508222875e-38
"""The largest and the smallest normal number of single precision, in which the engine computes: beyond
them a length becomes infinite or zero there."""

Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, le=LARGEST, allow_inf_nan=False)]
Extended = Annotated[float, Field(ge=-math.inf, allow_inf_nan=True)]
"""Infinite ones too; what is no number at all is less than nothing."""

Unit = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
PositiveInt = Annotated[int, Field(ge=1)]
NonNegativeInt = Annotated[int, Field(ge=0)]

MOST = 2**31 - 1
"""The engine's integers have 32 bits."""

Count = Annotated[int, Field(ge=1, le=MOST)]
CountOrNone = Annotated[int, Field(ge=0, le=MOST)]

Opening = Annotated[float, Field(gt=0, ge=SMALLEST, lt=math.pi)]
OpeningDegrees = Annotated[float, Field(gt=0, ge=SMALLEST, lt=180)]
"""Angles of views and of cones of light [rad], [degrees]."""

# YAML gives lists; strict tuples would refuse them.
Vec3 = Annotated[tuple[Finite, Finite, Finite], Strict(strict=False)]
Vec4 = Annotated[tuple[Finite, Finite, Finite, Finite], Strict(strict=False)]
NonNegative2 = Annotated[tuple[NonNegative, NonNegative], Strict(strict=False)]
NonNegative3 = Annotated[tuple[NonNegative, NonNegative, NonNegative], Strict(strict=False)]
Positive2 = Annotated[tuple[Positive, Positive], Strict(strict=False)]
Positive3 = Annotated[tuple[Positive, Positive, Positive], Strict(strict=False)]

Iterations = Annotated[int, Field(ge=1, le=255)]
VelocityIterations = Annotated[int, Field(ge=0, le=255)]
"""PhysX takes 1 to 255 position iterations and 0 to 255 velocity iterations (PxRigidDynamic)."""

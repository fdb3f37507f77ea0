"""Camera of a scenario file: mount, queries and field of view."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from ..base.errors import UserError
from ..base.quantities import Angle
from ..base.spec import Spec
from ..model.view import D435, Intrinsics
from .pose_spec import PoseSpec


class IntrinsicsSpec(Spec):
    """Focal lengths and principal point of a pinhole camera [pixel]."""

    fx: float = Field(gt=0)
    fy: float = Field(gt=0)
    cx: float
    cy: float


class CameraSpec(Spec):
    """Depth camera: on the robot's flange, or fixed in the world.

    The pose is that of its optical frame: z forward, x to the right, y down.
    """

    mount: Literal["flange", "world"] = "flange"
    at: PoseSpec = PoseSpec()
    queries: tuple[str, ...] = ()
    width: int = Field(D435.width, ge=16, le=4096)
    height: int = Field(D435.height, ge=16, le=4096)
    horizontal_fov: Angle | None = None
    intrinsics: IntrinsicsSpec | None = None
    noise: bool = True

    @model_validator(mode="after")
    def _is_a_camera(self) -> CameraSpec:
        if self.horizontal_fov is not None and self.intrinsics is not None:
            raise ValueError("a camera has 'horizontal_fov' or 'intrinsics', not both: each says how wide it sees")
        try:
            self.pinhole()
        except UserError as error:
            raise ValueError(str(error).removesuffix(".")) from error
        return self

    def pinhole(self) -> Intrinsics:
        """Return the intrinsics: as written, else of square pixels with ``horizontal_fov``, by default a D435's."""
        if self.intrinsics is not None:
            return Intrinsics(**self.intrinsics.model_dump(), width=self.width, height=self.height)
        return Intrinsics.from_field_of_view(self.width, self.height, self.horizontal_fov)

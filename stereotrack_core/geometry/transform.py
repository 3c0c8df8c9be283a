"""Rigid transforms, named ``target_from_source``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class RigidTransform:
    """A rotation followed by a translation: p_target = R p_source + t."""

    rotation: FloatArray  # (3, 3)
    translation: FloatArray  # (3,), metres

    @staticmethod
    def identity() -> RigidTransform:
        """The transform that changes nothing."""
        return RigidTransform(np.eye(3), np.zeros(3))

    def apply(self, points: FloatArray) -> FloatArray:
        """Transform points (..., 3)."""
        return np.asarray(points) @ self.rotation.T + self.translation

    def inverse(self) -> RigidTransform:
        """source_from_target."""
        transposed = self.rotation.T
        return RigidTransform(transposed, -transposed @ self.translation)

    def __matmul__(self, other: RigidTransform) -> RigidTransform:
        """``a_from_b @ b_from_c`` is ``a_from_c``."""
        return RigidTransform(
            self.rotation @ other.rotation, self.rotation @ other.translation + self.translation
        )

    def matrix(self) -> FloatArray:
        """Homogeneous matrix (4, 4)."""
        result = np.eye(4)
        result[:3, :3] = self.rotation
        result[:3, 3] = self.translation
        return result

"""Rays of pinhole cameras in computer vision's frame: x to the right of the picture, y down, z ahead."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._types import Array


def intrinsic_rays(intrinsic_matrix: Any, extrinsic_matrix: Any, width_px: int, height_px: int) -> Array:
    """float32 (height, width, 6): from the camera's centre through the middles of pixels, with directions that reach
    depth 1. The intrinsic matrix (3, 3) maps the camera's frame to pixels, the extrinsic (4, 4) the world to it."""
    intrinsic, extrinsic = np.asarray(intrinsic_matrix, "f8"), np.asarray(extrinsic_matrix, "f8")
    if intrinsic.shape != (3, 3) or extrinsic.shape != (4, 4):
        raise ValueError(f"matrices have the shapes (3, 3) and (4, 4), not {intrinsic.shape} and {extrinsic.shape}")
    rotation, translation = extrinsic[:3, :3], extrinsic[:3, 3]
    x, y = np.meshgrid(np.arange(width_px) + 0.5, np.arange(height_px) + 0.5)
    pixels = np.stack([x, y, np.ones_like(x)], axis=-1)
    rays = np.empty((height_px, width_px, 6), np.float32)
    rays[..., :3] = -rotation.T @ translation
    rays[..., 3:] = pixels @ (rotation.T @ np.linalg.inv(intrinsic)).T
    return rays


def look_at(fov_deg: float, center: Any, eye: Any, up: Any, width_px: int, height_px: int) -> Array:
    """Rays of a camera at `eye` that looks at `center`, with an angle from its left to its right edge. `up` is the
    frame's y axis, which rows count along: the first row is the farthest from it."""
    position, ahead = np.asarray(eye, "f8"), np.asarray(center, "f8") - np.asarray(eye, "f8")
    right = np.cross(np.asarray(up, "f8"), ahead)
    if not (np.linalg.norm(right) > 0 and np.isfinite(right).all()):
        raise ValueError("eye and center differ, and up is not along the view")
    axes = [right, np.cross(ahead, right), ahead]
    extrinsic = np.eye(4)
    extrinsic[:3, :3] = [axis / np.linalg.norm(axis) for axis in axes]
    extrinsic[:3, 3] = -extrinsic[:3, :3] @ position
    focal = 0.5 * width_px / np.tan(np.radians(fov_deg) / 2)
    intrinsic = np.array([[focal, 0, width_px / 2], [0, focal, height_px / 2], [0, 0, 1]])
    return intrinsic_rays(intrinsic, extrinsic, width_px, height_px)

"""Rays and points that are too far out for the type that they were given in."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from . import _proto, errors
from ._session import Session
from ._types import Array
from ._warnings import PrecisionWarning, warn
from .points import Points
from .rays import Rays
from .scene_info import SceneInfo

_MAX_SPACING = 1e-6  # share of the scene's diagonal, as the command has it
_SAMPLE = 65536      # positions that are looked at


def warn_of_origins(session: Session, scene: str, rays: Any, token: str) -> None:
    """Gives a PrecisionWarning if origins are float32, or less, and so far out that its values there are far apart for
    this scene. `token`: that of the revision that was cast at. Those that the server makes are double."""
    if isinstance(rays, Rays):
        _warn(session, scene, rays.origins, rays.origin_type, token, "rays are {} and begin")


def warn_of_points(session: Session, scene: str, points: Any, token: str) -> None:
    """The same of points. Those that the server makes are double."""
    if isinstance(points, Points):
        _warn(session, scene, points.positions, points.position_type, token, "points are {} and lie")


def _warn(session: Session, scene: str, positions: Array, given: np.dtype[Any], token: str, text: str) -> None:
    """`given`: the type that positions (n, 3) were given in."""
    if given.kind != "f" or given.itemsize > 4 or not len(positions):
        return
    reach, spacing = _reach(positions, given)
    known = session.diagonals
    if scene in known and spacing <= _MAX_SPACING * known[scene][1]:
        return
    if known.get(scene, ("", 0.0))[0] != token:
        try:
            info = SceneInfo.of(session.connection.call("GetScene", _proto.GetSceneRequest(name=scene)).scene)
        except errors.SightlineError:  # the answer is there, and a warning must not cost it
            return
        diagonal = 0.0 if info.bounds is None else float(np.linalg.norm(info.bounds[1] - info.bounds[0]))
        known[scene] = (info.token, diagonal)
    diagonal = known[scene][1]
    if diagonal > 0 and spacing > _MAX_SPACING * diagonal:
        name = f"float{8 * given.itemsize}"
        warn(f"{text.format(name)} up to {reach:.3g} from the origin, where {name} values are {spacing:.2g} "
             f"apart; the scene's diagonal is {diagonal:.3g}: pass float64", PrecisionWarning)


def _reach(positions: Array, given: np.dtype[Any]) -> "Tuple[float, float]":
    """The largest finite coordinate, and the distance there to the next value of their type."""
    sample = np.abs(positions[::-(-len(positions) // _SAMPLE)])
    reach = float(sample.max(initial=0.0, where=np.isfinite(sample)))
    with np.errstate(over="ignore", invalid="ignore"):
        return reach, float(np.spacing(given.newbyteorder("=").type(reach)))

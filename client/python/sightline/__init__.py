"""Ray queries, closest points and insides on scenes of a Sightline server, with NumPy arrays.

    import sightline

    client = sightline.connect("127.0.0.1:50151")      # or sightline.serve().client: a server of one's own
    scene = client.import_arrays("quad", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    hits = scene.cast([[0.2, 0.1, 5, 0, 0, -1]])
    hits.t, hits.node, hits.primitive, hits.position
    scene.closest([[0.2, 0.1, 5]]).distance

sightline.aio has the same for asyncio. sightline.trimesh_ray, sightline.trimesh_proximity and sightline.open3d_t have
classes for programs that were written for trimesh and Open3D. sightline.lidar has sensors that turn and move.
"""

from . import errors, updates
from ._proto import version as __version__
from ._warnings import PrecisionWarning
from .batch import Applied, Batch
from .client import Client, connect
from .errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, FailedPrecondition, Internal,
                     InvalidArgument, NotFound, OutOfRange, PermissionDenied, ResourceExhausted, SightlineError,
                     Unauthenticated, Unavailable, Unimplemented, Unknown)
from .hits import AllHits, Hits
from .nearest import AllNearest, Nearest
from .nodes import Node
from .picture import Picture
from .points import PointGrid, Points, as_points
from .rays import Rays, as_rays
from .scene import Scene, SceneInfo
from .server import Server, serve
from .shared_memory import SharedMemory, Transport
from .update_stream import UpdateStream
from .watch import Change

__all__ = [
    "Aborted", "AllHits", "AllNearest", "AlreadyExists", "Applied", "Batch", "Cancelled", "Change", "Client", "DataLoss",
    "DeadlineExceeded", "FailedPrecondition", "Hits", "Internal", "InvalidArgument", "Nearest", "Node", "NotFound",
    "OutOfRange", "PermissionDenied", "Picture", "PointGrid", "Points", "PrecisionWarning", "Rays", "ResourceExhausted",
    "Scene", "SceneInfo", "Server", "SharedMemory", "SightlineError", "Transport", "Unauthenticated", "Unavailable",
    "Unimplemented", "Unknown", "UpdateStream", "__version__", "as_points", "as_rays", "connect", "errors", "serve", "updates",
]

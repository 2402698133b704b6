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
from ._as_points import as_points
from ._proto import version as __version__
from ._warnings import FileWarning, PrecisionWarning
from .all_hits import AllHits
from .all_nearest import AllNearest
from .applied import Applied
from .backup_scene import BackupScene
from .batch import Batch
from .change import Change
from .client import Client, connect
from .deferred_cells import DeferredCells
from .errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, FailedPrecondition, Internal,
                     InvalidArgument, NotFound, OutOfRange, PermissionDenied, ResourceExhausted, SightlineError,
                     Unauthenticated, Unavailable, Unimplemented, Unknown)
from .hits import Hits
from .label import Label
from .log_lines import LogLines
from .nearest import Nearest
from .node_info import NodeInfo
from .node_mesh import NodeMesh
from .nodes import Node
from .picture import Picture
from .pinhole import Pinhole
from .point_grid import PointGrid
from .points import Points
from .prefetch_report import PrefetchReport
from .rays import Rays, as_rays
from .restored_scene import RestoredScene
from .scene import Scene
from .scene_info import SceneInfo
from .scene_stats import SceneStats
from .server import Server, serve
from .server_info import ServerInfo
from .shared_memory import SharedMemory, Transport
from .spherical_scan import SphericalScan
from .storage_limits import StorageLimits
from .update_stream import UpdateStream
from .visibility_pairs import VisibilityPairs

__all__ = [
    "Aborted", "AllHits", "AllNearest", "AlreadyExists", "Applied", "BackupScene", "Batch", "Cancelled", "Change",
    "Client", "DataLoss", "DeadlineExceeded", "DeferredCells", "FailedPrecondition", "FileWarning", "Hits", "Internal",
    "InvalidArgument", "Label", "LogLines", "Nearest", "Node", "NodeInfo", "NodeMesh", "NotFound", "OutOfRange",
    "PermissionDenied", "Picture", "Pinhole", "PointGrid", "Points", "PrecisionWarning", "PrefetchReport", "Rays",
    "ResourceExhausted", "RestoredScene", "Scene", "SceneInfo", "SceneStats", "Server", "ServerInfo", "SharedMemory",
    "SightlineError", "SphericalScan", "StorageLimits", "Transport", "Unauthenticated", "Unavailable", "Unimplemented",
    "Unknown", "UpdateStream", "VisibilityPairs", "__version__", "as_points", "as_rays", "connect", "errors", "serve",
    "updates",
]

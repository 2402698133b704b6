"""Unit costs: what one request, ray, triangle, update and notice take. Read from a CSV file whose rows name the command
that measured them."""
import dataclasses
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "docs/data"
FILE = DATA / "planning_costs.csv"

sys.path.insert(0, str(ROOT / "tests/bench/data"))
from csv_files import read_csv
from fleet import has_proxy


@dataclasses.dataclass(frozen=True)
class Costs:
    """Processor seconds (`_s`), bytes and triangles. A field is a row of the file."""
    client_request_s: float    # the client, a request of no rays
    client_ray_s: float
    client_proxied_s: float    # ... more for a request through HAProxy
    proxy_request_s: float     # HAProxy, a request of no rays
    proxy_ray_s: float
    proxy_bounded_s: float     # ... more for a request, where loads are bounded
    server_request_s: float    # a replica, a request of no rays, all trees built
    server_ray_s: float
    server_proxied_s: float    # ... more for a request through HAProxy
    open_scene_s: float        # the first request about a scene at a replica
    open_triangle_s: float     # ... for each triangle of the scene
    build_triangle_s: float    # for each triangle in finished leaves
    client_triangle_s: float   # clients on the same machine, whose caches building uses as well, for each of these triangles
    piece_triangles: float     # the trees that one ray builds, alone in its part of the scene
    geometry_bytes: float      # held for each triangle of a scene that is loaded
    tree_bytes: float          # held for each triangle in finished leaves
    request_bytes_ray: float   # on the wire
    reply_bytes_ray: float
    update_write_s: float      # the replica that takes an update
    update_follow_s: float     # a replica that reads it from the log, and has its scene loaded
    commit_s: float            # how long a transaction takes
    database_commit_s: float   # PostgreSQL, a transaction
    database_update_s: float   # PostgreSQL, for each update in it
    database_notice_s: float   # PostgreSQL, a notice for each replica that listens
    database_open_triangle_s: float  # PostgreSQL, for each triangle of a scene that a replica opens
    database_read_s: float     # PostgreSQL, a read of what is new in a scene

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not value >= 0:
                raise ValueError(f"unit cost {field.name} is {value}; it must be 0 or more")

    def warm_s(self, rays, policy):
        """A replica's processor seconds for a request whose trees are built."""
        return self.server_request_s + self.server_ray_s * rays + has_proxy(policy) * self.server_proxied_s

    def proxy_s(self, rays, policy):
        return has_proxy(policy) * (self.proxy_request_s + self.proxy_ray_s * rays + (policy == "bounded") * self.proxy_bounded_s)

    def client_s(self, rays, policy):
        return self.client_request_s + self.client_ray_s * rays + has_proxy(policy) * self.client_proxied_s

    def bytes(self, rays):
        """On the wire, both ways."""
        return (self.request_bytes_ray + self.reply_bytes_ray) * rays


def read_costs(path=FILE):
    """Errors: ValueError, a row is missing, or no field has its name."""
    rows = {row["name"]: row["value"] for row in read_csv(path)}
    names = {field.name for field in dataclasses.fields(Costs)}
    if rows.keys() != names:
        raise ValueError(f"{path}: missing {sorted(names - rows.keys())}, unknown {sorted(rows.keys() - names)}")
    return Costs(**rows)

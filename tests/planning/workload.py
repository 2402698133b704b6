"""What clients ask for: how many they are, which scenes they use, how large these are, and how much of them a request sees."""
import dataclasses

import numpy as np

SMALLEST, LARGEST = 1_000, 10_000_000  # triangles of a scene


@dataclasses.dataclass(frozen=True)
class Workload:
    clients: int = 1_000
    request_every_s: float = 1.0      # of each client
    rays: int = 1_024                 # a request
    window: float = 0.1               # the share of a scene's surface that a request looks at, somewhere
    scenes: int = 10_000
    zipf: float = 1.0                 # the k-th scene has k^-zipf of the requests of the first
    median_triangles: float = 100_000
    sigma: float = 1.0                # of the logarithm of a scene's triangles
    update_share: float = 0.01        # updates a request
    tree_life_s: float = 3_600        # mean time until a scene is replaced or its replica restarts: trees begin anew
    seed: int = 1

    def request_rate(self):
        """Requests a second, of all clients."""
        return self.clients / self.request_every_s


def popularity(workload):
    """The share of requests of each scene, most popular first."""
    weights = np.arange(1, workload.scenes + 1, dtype=float) ** -workload.zipf
    return weights / weights.sum()


def scene_triangles(workload):
    """Triangles of each scene. Size and popularity are independent."""
    random = np.random.default_rng(workload.seed)
    sizes = workload.median_triangles * np.exp(workload.sigma * random.standard_normal(workload.scenes))
    return np.clip(sizes, SMALLEST, LARGEST)


def reach(workload, triangles, piece_triangles):
    """The share of a scene's trees that one request needs: the pieces that its window touches, and that a ray falls on."""
    touched = np.minimum(1, (workload.window ** 0.5 + (piece_triangles / triangles) ** 0.5) ** 2)
    inside = np.maximum(1, workload.window * triangles / piece_triangles)
    return touched * -np.expm1(-workload.rays / inside)

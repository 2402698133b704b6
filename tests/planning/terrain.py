"""Scenes and rays for measuring: terrains over the unit square, and rays straight down through a window of them."""
import numpy as np

ABOVE = 2.0  # where rays start


def terrain(triangles, seed):
    """Vertices and faces of about so many triangles."""
    side = max(1, round((triangles / 2) ** 0.5))
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, side + 1), np.linspace(0, 1, side + 1), indexing="ij")
    z = 0.002 * random.random(x.shape)
    for _ in range(6):
        wave, turn = 2 * np.pi * random.integers(1, 8, 2), random.random()
        z += 0.02 * np.sin(wave[0] * x + wave[1] * y + 6.3 * turn)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    lower = np.stack([corner, corner + side + 1, corner + side + 2], -1)
    upper = np.stack([corner, corner + side + 2, corner + 1], -1)
    return np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32), np.stack([lower, upper], 1).reshape(-1, 3)


def window_rays(random, count, window):
    """Rows of origin and direction, over a window anywhere; the square is a torus, so that every part is seen as often."""
    at = (random.random(2) + window ** 0.5 * random.random((count, 2))) % 1
    down = np.broadcast_to([ABOVE, 0.0, 0.0, -1.0], (count, 4))
    return np.hstack([at, down]).astype(np.float32)

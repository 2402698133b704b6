"""The scenes that a replica has loaded, with the share of their trees that is built, within a memory budget."""
import collections
import dataclasses


@dataclasses.dataclass
class Loaded:
    triangles: float
    ends: float          # when it is replaced
    share: float = 0.0   # of its trees that is built


@dataclasses.dataclass(frozen=True)
class Visit:
    """What one request had to do."""
    opened: bool
    built: float         # triangles
    missing: float       # the part of what it needed that was not built, 0 to 1


class TreeCache:
    """The least recently used scene goes first. A scene larger than the budget stays alone."""

    def __init__(self, budget_bytes, geometry_bytes, tree_bytes):
        self._budget, self._geometry, self._tree = budget_bytes, geometry_bytes, tree_bytes
        self._scenes = collections.OrderedDict()
        self.bytes, self.evictions, self.built = 0.0, 0, 0.0

    def __contains__(self, scene):
        return scene in self._scenes

    def _bytes_of(self, loaded):
        return loaded.triangles * (self._geometry + self._tree * loaded.share)

    def _drop(self, scene):
        self.bytes -= self._bytes_of(self._scenes.pop(scene))

    def visit(self, now, scene, triangles, reach, life):
        """A request needs `reach` of a scene's trees, somewhere. `life` is how long the scene will stay as it is, if it is loaded now."""
        if scene in self._scenes and self._scenes[scene].ends <= now:
            self._drop(scene)
        opened = scene not in self._scenes
        if opened:
            self._scenes[scene] = Loaded(triangles, now + life)
            self.bytes += self._bytes_of(self._scenes[scene])
        self._scenes.move_to_end(scene)
        loaded = self._scenes[scene]
        missing = 1 - loaded.share
        built = triangles * reach * missing
        loaded.share += reach * missing
        self.bytes += built * self._tree
        self.built += built
        while self.bytes > self._budget and len(self._scenes) > 1:
            self._drop(next(iter(self._scenes)))
            self.evictions += 1
        return Visit(opened, built, missing)

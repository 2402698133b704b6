"""What is measured: one command for both programs each, by kind, scene, rays and number of threads."""
import dataclasses
import pathlib
from collections.abc import Callable

import readings

SCENES = {"bunny": "bunny.ply", "sponza": "sponza.glb", "conference": "conference.ply", "sibenik": "sibenik.ply",
          "fairy_forest": "fairy_forest.ply", "dragon": "dragon.ply", "terrain": "gen:terrain?triangles=4000000",
          "city": "gen:city?triangles=1000000", "torcs_forza": "torcs_forza.glb", "fzk_haus": "fzk_haus.ifc",
          "sterngarten": "sterngarten.obj", "saw": "reciprocating_saw.glb", "engine": "two_cylinder_engine.glb",
          "brainstem": "brainstem.glb", "herd": "gen:herd?copies=30&mesh={bunny.ply}"}
TRACED = tuple(name for name in SCENES if name != "herd")
GROWN = "dragon", "terrain", "city", "herd"
RAYS = "overview", "diffuse", "random", "shadow"
BUDGETS = 8, 16, 64  # references a triangle
KEPT, MERGED = FORMS = "kept", "merged"  # nodes as they are, and all as one mesh
OF_NODES = "city", "village", "herd", "swarm", "stadium", "box"  # generators
OF_ONE_MESH = ".ply", ".stl"  # files
PEER, SINGLE = "embree-medium-robust", "embree-medium-robust-single"


def has_nodes(text):
    """Whether this scene of sightline-bench can have several nodes. Other files than PLY and STL are not read: the answer is yes."""
    kind, _, rest = text.partition(":")
    if kind == "gen" and rest.partition("?")[0] in OF_NODES:
        return True
    file = text.partition("mesh=")[2].partition("&")[0] if kind == "gen" else text
    return bool(file) and pathlib.Path(file).suffix.lower() not in OF_ONE_MESH


@dataclasses.dataclass(frozen=True)
class Experiment:
    """`words` is the command without the program, from the verb on; `file` is the scene's file, which may not exist. `form` is one
    of FORMS; empty for a scene of one mesh, and for kinds that measure all scenes as they are."""
    kind: str
    scene: str
    rays: str
    threads: int
    words: tuple[str, ...]
    read: Callable
    file: pathlib.Path | None = None
    timed: bool = True
    form: str = ""

    @property
    def verb(self):
        return self.words[0]

    @property
    def title(self):
        threads = f"{self.threads} thread{'' if self.threads == 1 else 's'}" if self.threads else ""
        return ", ".join(part for part in (f"{self.kind} {self.scene}", self.form, self.rays, threads) if part)


class Plan:
    """Makes the experiments that the options of tests/bench/compare ask for. `lacking`: peers that one of the programs does not have."""

    def __init__(self, options, lacking=()):
        self.options, self.lacking = options, lacking
        self.folder = pathlib.Path(options.scenes_folder)

    def locate(self, scene):
        """The scene as sightline-bench takes it, and the file that it needs, if any."""
        text = SCENES.get(scene, scene)
        if not text.startswith("gen:"):
            return str(self.folder / text), self.folder / text
        before, opened, rest = text.partition("{")
        if not opened:
            return text, None
        name, _, after = rest.partition("}")
        return f"{before}{self.folder / name}{after}", self.folder / name

    def peers(self, *names):
        return tuple(name for name in names if name not in self.lacking) if self.options.embree else ()

    def forms(self):
        """Scenes, each with its form: those of nodes first with their nodes, then merged; those of one mesh only once, with the first."""
        asked = [form for form in FORMS if form in self.options.forms]
        for form in asked:
            for scene in self.options.scenes or TRACED:
                if has_nodes(self.locate(scene)[0]):
                    yield scene, form
                elif form == asked[0]:
                    yield scene, ""

    def make(self, kind, scene, rays, threads, verb, read, *words, timed=True, form=""):
        text, file = self.locate(scene) if scene else (None, None)
        common = [*(("--scene", text) if text else ()), *(("--merge",) if form == MERGED else ()),
                  *(("--threads", threads) if threads else ()), "--seed", self.options.seed]
        if timed:
            common += ["--repeat", self.options.repeat]
        return Experiment(kind, scene or "", rays, threads, tuple(map(str, [verb, *common, *words])), read, file, timed, form)

    def trace(self, threads):
        builders = ",".join(("scan-fast", *self.peers(PEER, SINGLE)))
        for scene, form in self.forms():
            for rays in self.options.rays:
                for kind in ("closest", "any") if rays == "shadow" else ("closest",):
                    yield self.make("trace", scene, f"{rays}, {kind}", threads, "trace", readings.trace, "--rays", rays, "--kind", kind,
                                    "--count", self.options.count, "--builder", builders,
                                    *(("--columns",) if self.options.columns else ()), form=form)

    def build(self, threads):
        builders = ",".join(("scan-fast", *self.peers(PEER, "embree-high")))
        for scene, form in self.forms():
            yield self.make("build", scene, "", threads, "build", readings.build, "--builder", builders, form=form)

    def lazy(self, threads):
        for scene in self.options.scenes or GROWN:
            yield self.make("lazy", scene, "closeup", threads, "lazy", readings.lazy, "--rays", "closeup", "--count",
                            min(10_000, self.options.count), "--modes", ",".join(("lazy", *self.peers("embree-low", "embree-lazy"))))

    def slivers(self, threads):
        for budget in BUDGETS:
            builders = ",".join((f"scan-fast?budget={budget}", *self.peers("embree-high")))
            yield self.make("slivers", "gen:slivers?triangles=30000", f"random, budget {budget}", threads, "trace", readings.trace,
                            "--rays", "random", "--count", min(3000, self.options.count), "--builder", builders)

    def offset(self, threads):
        """Without Embree, whose floats have wrong answers far from the origin."""
        for offset in ("0", "1e6"):
            yield self.make("offset", f"gen:icosphere?level=7&offset={offset}", "random", threads, "trace", readings.trace,
                            "--rays", "random", "--count", self.options.count, "--builder", "scan-fast")

    def motion(self, threads):
        peers = self.peers("embree-low", "embree-refit")
        frames = self.folder / "horse_gallop"
        yield dataclasses.replace(
            self.make("motion", None, "overview and shadow", threads, "dynamic", readings.motion, "--frames", frames, "--copies", 12,
                      "--rays", "overview", "--count", self.options.count, "--shadow", "--length", 12,
                      *(("--peers", ",".join(peers)) if peers else ())),
            scene="horse_gallop x 12", file=frames)

    def remote(self, threads):
        for scene in self.options.scenes or ("bunny",):
            yield self.make("remote", scene, "diffuse", threads, "remote", readings.remote, "--rays", "diffuse", "--count",
                            self.options.count, "--echo")

    def answers(self):
        for scene in self.options.scenes or TRACED:
            yield self.make("answers", scene, ", ".join(self.options.rays), 0, "answers", readings.answers, "--rays",
                            ",".join(self.options.rays), "--count", max(1, self.options.count // 100), "--builder", "scan-fast",
                            timed=False)

    def robust(self):
        yield self.make("robust", "bunny", "", 0, "robust", readings.robust, "--builder", "scan-fast", "--count", self.options.count,
                        "--level", 5, timed=False)

    def experiments(self):
        found = []
        for kind in self.options.kinds:
            if kind in UNTIMED:
                found += getattr(self, kind)()
            else:
                found += [experiment for threads in self.options.threads for experiment in getattr(self, kind)(threads)]
        return found


KINDS = "trace", "build", "lazy", "slivers", "offset", "motion", "remote", "answers", "robust"
UNTIMED = "answers", "robust"

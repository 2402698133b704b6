"""Quotients are right, answers must be equal in all runs, and failures are told with their commands."""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import readings
from experiments import FORMS, SINGLE, Experiment, Plan, has_nodes
from programs import Failed, Program
from quotients import gains, geometric_mean, quantile, quartiles
from tables import table, tables
from turns import NEW, OLD, compare, take_turns


class Quotients(unittest.TestCase):
    def test_quartiles_lie_between_the_sorted_values(self):
        self.assertEqual(quartiles([4, 1, 3, 2, 5]), (3, 2, 4))
        self.assertEqual(quartiles([1, 2]), (1.5, 1.25, 1.75))
        self.assertEqual(quartiles([7]), (7, 7, 7))
        self.assertEqual(quantile([10, 0], 1), 10)

    def test_a_gain_is_a_quotient_within_a_pair(self):
        self.assertEqual(gains([2, 9], [1, 3]), [2, 3])
        self.assertEqual(quartiles(gains([10, 1, 10], [10, 1, 5]))[0], 1)

    def test_a_cost_that_is_not_positive_has_no_quotient(self):
        self.assertIsNone(gains([1, 2], [1, 0]))
        self.assertIsNone(gains([-1, 2], [1, 1]))

    def test_twice_and_half_have_the_mean_one(self):
        self.assertAlmostEqual(geometric_mean([2, 0.5]), 1)


def trace_row(builder, milliseconds, **more):
    return {"builder": builder, "trace_ms": milliseconds, "count": 1000, "hits": 5, "hit_hash": "a", **more}


class Readings(unittest.TestCase):
    def test_costs_are_those_of_a_ray_by_side(self):
        costs, answers = readings.trace([trace_row("scan-fast", 2), trace_row("embree-high", 3, hit_hash="b", unexplained=0)])
        self.assertEqual(costs, {("trace", "ns/ray"): {"ours": 2000, "embree-high": 3000}})
        self.assertEqual(answers["hit_hash"], "a")

    def test_answers_that_nothing_explains_fail(self):
        with self.assertRaisesRegex(Failed, "embree-high: 1 answers"):
            readings.trace([trace_row("scan-fast", 2), trace_row("embree-high", 3, unexplained=1)])

    def test_lost_rays_fail(self):
        row = {"family": "f", "kind": "k", "builder": "b", "policy": "p", "method": "exact", "rays": 9, "missed": 0, "extra": 0,
               "mismatched": 0}
        self.assertEqual(readings.robust([row, {**row, "method": "plain-float", "missed": 3}])[1]["rays"], 9)
        with self.assertRaisesRegex(Failed, "extra"):
            readings.robust([{**row, "extra": 1}])

    def test_frames_a_second_become_milliseconds(self):
        costs, answers = readings.motion([{"frame": 0, "hit_hash": "a"}, {"fps": 20, "embree_low_fps": 40, "embree_low_unexplained": 0}])
        self.assertEqual(costs, {("frame", "ms"): {"ours": 50, "embree-low": 25}})
        self.assertEqual(answers, {"frames": ["a"]})


class Scripted:
    """A program whose runs are given."""

    def __init__(self, name, log, times, hashes):
        self.name, self.log, self.runs = name, log, list(zip(times, hashes))

    def rows(self, words):
        self.log.append(self.name)
        milliseconds, hit_hash = self.runs.pop(0)
        return [trace_row("scan-fast", milliseconds, hit_hash=hit_hash), trace_row("embree-high", 4, unexplained=0)]

    def command(self, words):
        return " ".join([self.name, *words])


EXPERIMENT = Experiment("trace", "bunny", "diffuse", 1, ("trace",), readings.trace)


class Turns(unittest.TestCase):
    def turns(self, old, new, pairs=3):
        self.log = []
        programs = {OLD: Scripted(OLD, self.log, *old), NEW: Scripted(NEW, self.log, *new)}
        return take_turns(programs, EXPERIMENT, pairs)

    def test_each_is_first_in_every_other_pair(self):
        self.turns(([1, 1, 1], "aaa"), ([1, 1, 1], "aaa"))
        self.assertEqual(self.log, [OLD, NEW, NEW, OLD, OLD, NEW])

    def test_rows_have_the_medians_of_quotients_over_old_and_embree(self):
        costs, answers = self.turns(([2, 4, 6], "aaa"), ([1, 1, 2], "aaa"))
        old, embree = compare(EXPERIMENT, costs)
        self.assertEqual((old["over"], old["theirs"], old["new"], old["gain"], old["form"]), (OLD, 4000, 1000, 3, ""))
        self.assertEqual((old["gain_q1"], old["gain_q3"], old["pairs"]), (2.5, 3.5, 3))
        self.assertEqual((embree["over"], embree["gain"]), ("embree-high", 4))
        self.assertEqual(answers["hit_hash"], "a")

    def test_another_answer_fails_in_old_new_and_repeats(self):
        for old, new in ("aaa", "bbb"), ("aaa", "aba"), ("aab", "aaa"):
            with self.assertRaisesRegex(Failed, "answers differ"):
                self.turns(([1, 1, 1], old), ([1, 1, 1], new))


class Tables(unittest.TestCase):
    def row(self, scene, gain, **more):
        return {"kind": "trace", "scene": scene, "form": "", "rays": "random", "threads": 1, "quantity": "trace", "unit": "ns/ray",
                "over": OLD, "pairs": 3, "new": 10.0, "theirs": 10.0 * gain, "gain": gain, "gain_q1": gain, "gain_q3": gain, **more}

    def test_several_lines_have_a_mean(self):
        text = table([self.row("bunny", 2.0), self.row("dragon", 0.5)])
        self.assertIn("2.00 [2.00, 2.00]", text)
        self.assertRegex(text.splitlines()[-1], r"geometric mean\s+1.00")

    def test_each_form_has_a_mean_to_which_scenes_of_one_mesh_belong(self):
        lines = table([self.row("bunny", 2.0), self.row("sponza", 8.0, form="kept"), self.row("sponza", 0.5, form="merged")]).splitlines()
        self.assertRegex(lines[2], r"^sponza, kept  +random .* 8.00")
        self.assertRegex(lines[3], r"^sponza, merged  +random .* 0.50")
        self.assertRegex(lines[4], r"^geometric mean, kept  +4.00$")
        self.assertRegex(lines[5], r"^geometric mean, merged  +1.00$")

    def test_one_form_has_one_mean(self):
        lines = table([self.row("bunny", 2.0), self.row("sponza", 8.0, form="kept")]).splitlines()
        self.assertRegex(lines[-1], r"^geometric mean  +4.00$")

    def test_each_number_of_threads_has_a_table(self):
        text = tables([self.row("bunny", 2.0), self.row("bunny", 2.0, threads=2)])
        self.assertIn("trace, ns/ray, 1 thread\n", text)
        self.assertIn("trace, ns/ray, 2 threads\n", text)


class Plans(unittest.TestCase):
    def plan(self, lacking=(), **more):
        options = {"kinds": ["trace"], "threads": [1, 2], "scenes": ["bunny", "herd"], "rays": ["random", "shadow"], "count": 100,
                   "repeat": 1, "seed": 1, "embree": True, "scenes_folder": "/scenes", "forms": list(FORMS), "columns": False,
                   **more}
        return Plan(argparse.Namespace(**options), lacking).experiments()

    def test_shadow_rays_are_traced_for_the_closest_and_any_hit(self):
        self.assertEqual([e.title for e in self.plan(scenes=["bunny"], threads=[1])],
                         ["trace bunny, random, closest, 1 thread", "trace bunny, shadow, closest, 1 thread",
                          "trace bunny, shadow, any, 1 thread"])

    def test_columns_are_asked_of_the_program(self):
        plain, = self.plan(scenes=["bunny"], rays=["random"], threads=[1])
        other, = self.plan(scenes=["bunny"], rays=["random"], threads=[1], columns=True)
        self.assertEqual(set(other.words) - set(plain.words), {"--columns"})

    def test_scenes_of_nodes_are_measured_with_them_and_then_merged(self):
        for kind in "trace", "build":
            plan = self.plan(kinds=[kind], scenes=["sponza", "bunny", "city"], rays=["random"], threads=[1])
            self.assertEqual([(e.scene, e.form, "--merge" in e.words) for e in plan],
                             [("sponza", "kept", False), ("bunny", "", False), ("city", "kept", False), ("sponza", "merged", True),
                              ("city", "merged", True)])
            self.assertTrue(plan[3].title.startswith(f"{kind} sponza, merged"))

    def test_one_form_is_measured_if_it_is_asked_for(self):
        plan = lambda *forms: [(e.scene, e.form) for e in self.plan(scenes=["sponza", "bunny"], rays=["random"], threads=[1], forms=forms)]
        self.assertEqual(plan("kept"), [("sponza", "kept"), ("bunny", "")])
        self.assertEqual(plan("merged"), [("sponza", "merged"), ("bunny", "")])

    def test_what_can_have_nodes_is_seen_by_its_name(self):
        for text in ("fzk_haus.ifc", "/a/sponza.glb", "gen:city?boxes=9", "gen:stadium", "gen:shuffled?mesh=a.obj&seed=2",
                     "gen:box?mesh=a.ply"):
            self.assertTrue(has_nodes(text), text)
        for text in "bunny.ply", "/a/part.STL", "gen:terrain?triangles=9", "gen:wall", "gen:shuffled?mesh=a.ply&seed=2":
            self.assertFalse(has_nodes(text), text)

    def test_single_rays_are_traced_by_embree_where_both_programs_can(self):
        peers = lambda **more: self.plan(scenes=["bunny"], rays=["random"], threads=[1], **more)[0].words[-1]
        self.assertEqual(peers(), "scan-fast,embree-medium-robust,embree-medium-robust-single")
        self.assertEqual(peers(lacking=[SINGLE]), "scan-fast,embree-medium-robust")

    def test_generated_scenes_need_the_files_that_they_name(self):
        files = {e.scene: e.file for e in self.plan(scenes=["bunny", "herd", "terrain", "gen:stadium"])}
        bunny = pathlib.Path("/scenes/bunny.ply")
        self.assertEqual(files, {"bunny": bunny, "herd": bunny, "terrain": None, "gen:stadium": None})

    def test_without_embree_no_command_names_it(self):
        kinds = ["trace", "build", "lazy", "slivers", "offset", "motion"]
        self.assertFalse([e for e in self.plan(kinds=kinds, embree=False) if "embree" in " ".join(e.words)])


BENCH = """#!{python}
import sys
if sys.argv[1:] == ["trace", "--help"]:
    print("  --builder TEXT scan-fast|{peer}; several by commas")
elif "--help" in sys.argv:
    print("Subcommands:\\n  trace   Answer rays")
elif "gen:bad" in sys.argv:
    sys.exit("no such scene")
else:
    print('{{"builder": "scan-fast", "trace_ms": 2.0, "count": 10, "hits": 1, "hit_hash": "{hash}"}}')
"""


class Command(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def program(self, name, answers="a", peer=SINGLE):
        path = self.folder / name
        path.write_text(BENCH.format(python=sys.executable, hash=answers, peer=peer))
        path.chmod(0o755)
        return path

    def run_compare(self, old, new, *words):
        return subprocess.run([sys.executable, HERE.parent / "compare", "--old", old, "--new", new, "--quick", "--rays", "random", "--out",
                               self.folder / "out", *words], capture_output=True, text=True)

    def test_a_failed_run_is_reported_and_the_rest_goes_on(self):
        done = self.run_compare(self.program("old"), self.program("new"), "--scenes", "gen:bad,gen:good,missing.ply", "--kinds",
                                "trace,build")
        self.assertEqual(done.returncode, 1)
        self.assertIn("old trace --scene gen:bad", done.stdout)
        self.assertIn("no such scene", done.stdout)
        self.assertIn("experiments: 1 measured, with equal answers in all runs; 4 skipped, 1 failed", done.stdout)
        written = json.loads((self.folder / "out.json").read_text())
        self.assertEqual([(row["scene"], row["gain"]) for row in written["figures"]], [("gen:good", 1.0)])
        self.assertIn("gen:good", (self.folder / "out.csv").read_text())

    def test_other_answers_have_no_figures(self):
        done = self.run_compare(self.program("old"), self.program("new", "b"), "--scenes", "gen:good", "--kinds", "trace")
        self.assertEqual(done.returncode, 1)
        self.assertIn("answers differ", done.stdout)
        self.assertNotIn("ns/ray", done.stdout)

    def test_equal_programs_are_well(self):
        program = self.program("same")
        self.assertEqual(self.run_compare(program, program, "--scenes", "gen:good", "--kinds", "trace").returncode, 0)

    def test_a_peer_that_a_program_does_not_have_is_skipped(self):
        done = self.run_compare(self.program("old", peer="embree-medium-robust"), self.program("new"), "--scenes", "gen:good", "--kinds",
                                "trace")
        self.assertEqual(done.returncode, 0)
        self.assertIn(f"{SINGLE}: not in the old program", done.stdout)
        self.assertIn("1 measured, with equal answers in all runs; 1 skipped, 0 failed", done.stdout)

    def test_a_run_without_end_fails(self):
        path = self.folder / "slow"
        path.write_text(f"#!{sys.executable}\nimport sys, time\nif '--help' not in sys.argv: time.sleep(60)\n")
        path.chmod(0o755)
        with self.assertRaisesRegex(Failed, "no end within 0.2 s"):
            program = Program(path, 60)
            program.seconds = 0.2
            program.output(["trace"])


if __name__ == "__main__":
    unittest.main()

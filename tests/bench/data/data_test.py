"""CSV files are read as they were written, rows become the right tables, and a page that differs from its data is found."""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import builders
import summaries
from csv_files import read_csv, read_provenance, record, write_csv


class Bench:
    commands, seconds, load = ["sightline-bench kernel"], 2.4, 0.5


class CsvFiles(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_empty_cells_are_left_out_and_numbers_are_numbers(self):
        write_csv(self.folder / "a.csv", [{"name": "x, y", "n": 3, "ok": True}, {"name": "z", "rate": 0.123456, "n": None}])
        self.assertEqual(read_csv(self.folder / "a.csv"), [{"name": "x, y", "n": 3, "ok": "yes"}, {"name": "z", "rate": 0.1235}])

    def test_large_numbers_keep_their_digits(self):
        write_csv(self.folder / "a.csv", [{"touches": 123456789, "rate": 1234567.8}])
        self.assertEqual(read_csv(self.folder / "a.csv"), [{"touches": 123456789, "rate": 1234568}])

    def test_provenance_of_one_file_leaves_the_others(self):
        record(self.folder, ["a.csv"], Bench, {"commit": "1"})
        record(self.folder, ["b.csv"], Bench, {"commit": "2"})
        known = read_provenance(self.folder)
        self.assertEqual({name: run["commit"] for name, run in known.items()}, {"a.csv": "1", "b.csv": "2"})
        self.assertEqual(known["a.csv"]["commands"], Bench.commands)


class Builders(unittest.TestCase):
    def test_build_and_rays_of_a_configuration_become_one_row(self):
        common = {"scene": "bunny", "triangles": "100", "builder": "sbvh", "configuration": "sbvh?alpha=1", "line": "alpha",
                  "value": "1", "usual": "0"}
        build = {**common, "study": "build", "build_ms": "2.5", "mtris_per_s": "0.04", **{key: "7" for key in builders.TREE}}
        trace = {**common, "study": "trace", "rays": "diffuse", "steps_per_ray": "4", "tests_per_ray": "2", "work_over_sweep": "0.5",
                 "trace_over_sweep": "", "mrays_per_s": "1.5"}
        (row,) = builders.builder_rows([build, trace, {"study": "image"}])
        self.assertEqual((row["build_ms"], row["references"], row["diffuse_steps"], row["default"]), (2.5, 7, 4, False))
        self.assertIsNone(row["diffuse_time_over_sweep"])

    def test_a_law_that_holds_is_fitted_without_residual(self):
        law = builders.LAWS["N log N"]
        a, residual = builders.fit([(n, 3 * law(n)) for n in (16, 64, 1024)], law)
        self.assertAlmostEqual(a, 3)
        self.assertAlmostEqual(residual, 0)
        self.assertGreater(builders.fit([(n, n * n) for n in (16, 64, 1024)], law)[1], 0.5)

    def test_published_figures_name_quantities_that_a_build_has(self):
        row = {key: 1.0 for key in ("mtris_per_s", "build_ms", "expected_traversals", "expected_intersections", "references",
                                    "nonempty_leaves", "leaves", "expected_leaves", "sah_cost", "overlap")}
        known = builders.quantities(row, row)
        for _, figures in builders.PUBLISHED:
            for _, _, quantity, _ in figures:
                self.assertIn(quantity, known)


class Pages(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = pathlib.Path(temporary.name)
        self.folder = self.root / "docs" / "data"
        self.folder.mkdir(parents=True)
        self.page = self.root / "docs" / "page.md"
        self.page.write_text("Before.\n\n<!-- data: kernel -->\n<!-- end -->\n\nAfter.\n")
        self.write(490.2)

    def write(self, rate):
        row = {"pass": "scan", "planes": 8, "axes": 3, "boxes": 100, "mboxes_per_s": rate}
        write_csv(self.folder / "kernel.csv", [row, {**row, "boxes": 1000, "mboxes_per_s": 100.0}])

    def test_a_page_gets_the_table_of_its_data_and_keeps_its_text(self):
        self.assertEqual(summaries.outdated(self.root, self.folder), ["docs/page.md"])
        summaries.fill(self.root, self.folder)
        self.assertEqual(summaries.outdated(self.root, self.folder), [])
        text = self.page.read_text()
        self.assertIn("| scan | 8 x 3 | 490 | 100 |", text)
        self.assertTrue(text.startswith("Before.") and text.endswith("After.\n"))

    def test_new_data_makes_the_page_outdated(self):
        summaries.fill(self.root, self.folder)
        self.write(300.0)
        self.assertEqual(summaries.outdated(self.root, self.folder), ["docs/page.md"])


class Lines(unittest.TestCase):
    def test_a_method_that_is_alike_in_every_family_has_one_line(self):
        lines = [["a", "exact", "0"], ["a", "float", "1 %"], ["b", "exact", "0"], ["b", "float", "2 %"]]
        self.assertEqual(summaries.alike_once(lines),
                         [["all", "exact", "0"], ["a", "float", "1 %"], ["b", "float", "2 %"]])

    def test_a_method_that_some_family_lacks_keeps_its_lines(self):
        lines = [["a", "exact", "0"], ["a", "float", "0"], ["b", "float", "0"]]
        self.assertEqual(summaries.alike_once(lines), [["all", "float", "0"], ["a", "exact", "0"]])


class Tables(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_wrong_answers_are_failures(self):
        row = {"builder": "sah", "failed_by_design": "", "failures": "", "relative_work": 1.0}
        write_csv(self.folder / "stability.csv",
                  [{**row, "family": "fan", "wrong": 2}, {**row, "family": "book", "wrong": 0}])
        self.assertIn("| `sah` | 2 | none | fan: 2 wrong answers | 1 | 1 |", summaries.stability(self.folder))

    def test_times_of_papers_stay_in_the_file(self):
        row = {"source": "a", "scene": "bunny", "builder": "sah", "published": 3.0, "here": 2.0}
        write_csv(self.folder / "papers.csv", [{**row, "quantity": "seconds"}, {**row, "quantity": "expected_leaves"}])
        self.assertEqual(summaries.papers(self.folder).splitlines()[2:],
                         ["| a | bunny | `sah` | expected leaves: 3 / 2 |"])


class Numbers(unittest.TestCase):
    def test_numbers_have_three_digits(self):
        self.assertEqual([summaries.show(v) for v in (None, 0, 0.01234, 1.0, 12.345, 12345.6, "a")],
                         ["-", "0", "0.0123", "1", "12.3", "12,346", "a"])

    def test_shares_are_percent(self):
        self.assertEqual([summaries.percent(v) for v in (0, 0.00012, 0.5)], ["0", "0.012 %", "50 %"])


if __name__ == "__main__":
    unittest.main()

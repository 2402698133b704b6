"""Each check finds what it is for, and nothing else: small trees with faults planted in them."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))

import dependants
import layers
import links
import namespaces
import ray_path
import sources
import words


class Tree(unittest.TestCase):
    """A scratch checkout."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, file, text):
        path = self.root / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def findings_in(self, check, file, text):
        """What is said of a file that is the whole tree, and then removed."""
        self.write(file, text)
        findings = check(self.root)
        (self.root / file).unlink()
        return findings

    def assert_clean(self, check, file, text):
        self.assertEqual(self.findings_in(check, file, text), [], text)

    def assert_found(self, check, file, text, *wanted):
        """One finding for each of wanted, which is a part of it."""
        findings = self.findings_in(check, file, text)
        self.assertEqual(len(findings), len(wanted), findings)
        for finding, part in zip(findings, wanted):
            self.assertIn(part, finding)


class Layers(Tree):
    ALLOWED = [
        ("accel/kdtree/a.h", '"accel/kdtree/slot.h"'),
        ("accel/kdtree/a.h", '"accel/geometry/aabb.h"'),
        ("accel/kdtree/a.h", "<vector>"),
        ("accel/kdtree/a.h", "<sys/mman.h>"),
        ("accel/split/a.h", "<hwy/highway.h>"),
        ("accel/published/bvh/a.h", '"accel/mesh/face_boxes.h"'),
        ("accel/published/a.h", '"accel/published/kd/event_sweep.h"'),
        ("scenegraph/model/a.cpp", '"accel/mesh/mesh_tree.h"'),
        ("scenegraph/revision/a.cpp", "<tbb/parallel_for.h>"),
        ("scenegraph/trace.cpp", '"scenegraph/query/caster.h"'),
        ("scenegraph/query/a.h", '"scenegraph/trace_options.h"'),
        ("server/queries/a.cpp", '"scenegraph/trace.h"'),
        ("server/queries/a.cpp", '"sightline/v1/query.pb.h"'),
        ("server/exec/a.cpp", '"google/rpc/status.pb.h"'),
        ("server/exec/a.cpp", "<spdlog/spdlog.h>"),
        ("server/server.cpp", '"server/updates/apply_rpc.h"'),
        ("client/client.cpp", '"client/calls/channel.h"'),
        ("client/calls/a.cpp", '"sightline/v1/query.grpc.pb.h"'),
        ("client/calls/a.cpp", "<grpcpp/grpcpp.h>"),
        ("client/cli/verbs/a.cpp", '"client/importer/assimp_import.h"'),
        ("client/cli/verbs/a.cpp", '"client/cli/files/npy.h"'),
        ("client/cli/picture/a.cpp", "<png.h>"),
        ("client/importer/a.cpp", '"client/mesh_arrays.h"'),
        ("client/importer/a.cpp", "<assimp/scene.h>"),
    ]
    REFUSED = [
        ("accel/geometry/b.h", '"accel/kdtree/slot.h"'),
        ("accel/kdtree/b.h", '"accel/split/cost_model.h"'),
        ("accel/grow/b.h", '"accel/lazy/lazy_tree.h"'),
        ("accel/mesh/b.h", '"accel/published/bvh/bvh.h"'),
        ("accel/kdtree/b.h", '"scenegraph/model/node.h"'),
        ("accel/kdtree/b.h", '"slot.h"'),
        ("accel/kdtree/b.h", '"../kdtree/slot.h"'),
        ("accel/kdtree/b.h", "<spdlog/spdlog.h>"),
        ("accel/kdtree/b.h", "<boost/any.hpp>"),
        ("accel/kdtree/b.h", '"tests/support/scenes.h"'),
        ("accel/unlisted/b.h", "<vector>"),
        ("scenegraph/model/b.h", '"scenegraph/hierarchy/node_summary.h"'),
        ("scenegraph/query/b.h", '"scenegraph/trace.h"'),
        ("scenegraph/scene.cpp", '"accel/published/any_builder.h"'),
        ("scenegraph/scene.cpp", '"server/queries/hit_codec.h"'),
        ("scenegraph/scene.cpp", '"sightline/v1/query.pb.h"'),
        ("scenegraph/scene.cpp", "<grpcpp/grpcpp.h>"),
        ("server/exec/b.h", '"server/queries/cast_job.h"'),
        ("server/updates/b.h", '"server/queries/cast_job.h"'),
        ("server/server.cpp", '"client/client.h"'),
        ("server/server.cpp", "<assimp/scene.h>"),
        ("client/client.h", '"client/calls/channel.h"'),
        ("client/calls/b.cpp", '"accel/geometry/vec3.h"'),
        ("client/calls/b.cpp", '"scenegraph/scene.h"'),
        ("client/calls/b.cpp", "<assimp/scene.h>"),
        ("client/calls/b.cpp", "<spdlog/spdlog.h>"),
        ("client/cli/files/b.cpp", '"client/cli/verbs/verbs.h"'),
        ("client/importer/b.cpp", '"client/calls/channel.h"'),
        ("client/importer/b.cpp", '"sightline/v1/scene.pb.h"'),
        ("client/importer/b.cpp", "<grpcpp/grpcpp.h>"),
    ]

    def test_includes_that_go_down_pass(self):
        for file, header in self.ALLOWED:
            self.assert_clean(layers.check, file, f"#include {header}\n")

    def test_includes_that_go_up_or_across_are_found(self):
        for file, header in self.REFUSED:
            with self.subTest(file=file, header=header):
                self.assert_found(layers.check, file, f"// first line\n#include {header}\n", file)

    def test_a_table_with_a_circle_is_found(self):
        self.assertEqual(list(layers.circles(layers.parse(layers.ROOMS))), [])
        self.assertEqual(len(list(layers.circles(layers.parse("a/b  a/c\na/c  a/b\n")))), 1)


class Dependants(Tree):
    def write_sources(self, header, count):
        for i in range(count):
            self.write(f"server/exec/a{i}.cpp", f'#include "{header}"\n')

    def test_a_header_of_a_tree_with_many_dependants_is_found(self):
        self.write("accel/lazy/demand.h", "")
        self.write("accel/lazy/lazy_tree.h", '#include "accel/lazy/demand.h"\n')
        self.write_sources("accel/lazy/lazy_tree.h", dependants.MOST)
        self.assertEqual(dependants.check(self.root), [])
        self.write("client/one_more.cpp", '#include "accel/lazy/demand.h"\n')
        findings = dependants.check(self.root)
        self.assertEqual(len(findings), 1, findings)
        self.assertIn(f"accel/lazy/demand.h: has {dependants.MOST + 1} dependants", findings[0])

    def test_headers_of_tests_and_sources_elsewhere_do_not_count(self):
        self.write("accel/wide/packet.h", "")
        self.write_sources("accel/wide/packet.h", dependants.MOST)
        self.write("accel/wide/other.h", '#include "accel/wide/packet.h"\n')
        self.write("tests/accel/wide/packet_test.cpp", '#include "accel/wide/packet.h"\n')
        self.assertEqual(dependants.check(self.root), [])

    def test_the_vocabulary_has_any_number_but_includes_only_itself(self):
        self.write("accel/geometry/vec3.h", "")
        self.write("accel/mesh/tree_builder.h", '#include <memory>\n#include "accel/geometry/vec3.h"\n')
        self.write_sources("accel/mesh/tree_builder.h", dependants.MOST + 1)
        self.assertEqual(dependants.check(self.root), [])
        self.write("accel/mesh/mesh_tree.h", "")
        self.write("accel/mesh/tree_builder.h", '#include "accel/mesh/mesh_tree.h"\n')
        findings = dependants.check(self.root)
        self.assertIn("accel/mesh/tree_builder.h: includes accel/mesh/mesh_tree.h", "\n".join(findings))

    def test_circles_end(self):
        self.write("accel/lazy/a.h", '#include "accel/lazy/b.h"\n')
        self.write("accel/lazy/b.h", '#include "accel/lazy/a.h"\n')
        self.write("accel/lazy/a.cpp", '#include "accel/lazy/a.h"\n')
        self.assertEqual(dependants.check(self.root), [])


class Namespaces(Tree):
    def test_namespaces_of_folders_pass(self):
        for file, text in [
            ("accel/kdtree/slot.h", "namespace sightline::accel::kdtree {\nclass Slot { int a; };\n}\n"),
            ("accel/kdtree/slot.cpp", "namespace sightline::accel::kdtree {\nnamespace {\nint f() { return 1; }\n}\n}\n"),
            ("accel/kdtree/a.h", "namespace sightline::accel::lazy {\nclass Tree;\n}\n"
                                 "namespace sightline::accel::kdtree {\nenum class A : int { k };\n}\n"),
            ("scenegraph/scene.h", "namespace sightline::scenegraph {\ntemplate <class T>\nstruct A final : B<T> {};\n}\n"),
            ("server/a.h", "struct aiScene;\nnamespace grpc {\nclass Channel;\n}\n"
                           "template <>\nstruct std::hash<A> {\n};\n"),
            ("server/main.cpp", "namespace {\nvoid serve() {}\n}\nint main() {\n  try { serve(); } catch (...) {}\n}\n"),
            ("tests/accel/kdtree/slot_test.cpp", "namespace sightline::accel::kdtree {\nTEST(A, B) {}\n}\n"),
            ("tests/accel/kdtree/slot_test.cpp", "namespace sightline::tests {\nstruct A {};\n}\n"),
            ("tests/bench/verbs/a.cpp", "namespace sightline::bench {\nstruct A {};\n}\n"),
            ("tests/fuzz/a.cpp", 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data) {\n  return 0;\n}\n'),
        ]:
            (self.root / "accel/lazy").mkdir(parents=True, exist_ok=True)
            self.assert_clean(namespaces.check, file, text)

    def test_what_is_elsewhere_is_found(self):
        (self.root / "accel/lazy").mkdir(parents=True)
        for file, text, wanted in [
            ("accel/kdtree/a.h", "namespace sightline::accel {\nclass Slot {};\n}\n", "accel/kdtree/a.h:1"),
            ("accel/kdtree/a.h", "namespace sightline::accel::lazy {\nint f();\n}\n", "sightline::accel::kdtree"),
            ("accel/kdtree/a.h", "namespace sightline::accel::gone {\nclass A;\n}\n", "accel/kdtree/a.h:1"),
            ("accel/kdtree/a.h", "class Slot {\n};\n", "Slot is defined outside"),
            ("accel/kdtree/a.cpp", "// ok\nint f() {\n  return 1;\n}\n", "a.cpp:2: f is defined outside"),
            ("accel/kdtree/a.cpp", "const int kA = 1'000;\n", "kA is defined outside"),
            ("accel/kdtree/a.cpp", "namespace std {\nstruct A { int a; };\n}\n", "defines a type in std"),
            ("tests/accel/kdtree/a_test.cpp", "namespace sightline::accel::lazy {\nTEST(A, B) {}\n}\n", "a_test.cpp:1"),
        ]:
            with self.subTest(text=text):
                self.assert_found(namespaces.check, file, text, wanted)

    def test_a_type_defined_twice_in_a_namespace_is_found(self):
        self.write("accel/lazy/expansion.h", "namespace sightline::tests {\nclass Other;\n}\n")
        self.write("tests/a.h", "namespace sightline::tests {\nclass Expansion;\nstruct Same {};\n}\n")
        self.write("tests/b.h", "namespace sightline::tests {\nclass Expansion { int a = {1}; };\n}\n")
        self.write("tests/d.cpp", "namespace sightline::tests {\nnamespace {\nstruct Same {};\n}\n}\n")
        self.assert_found(namespaces.check, "tests/c.h",
                          "namespace sightline::tests {\nint a{1};\nenum Expansion { k };\n}\n",
                          "tests/b.h:2 and tests/c.h:3: sightline::tests::Expansion is defined 2 times")


class Words(Tree):
    def test_plain_words_pass(self):
        for file, text in [
            ("accel/kdtree/a.h", "// Nothing of the kind; in place of a list.\nint index = std::is_placeholder_v<int>;\n"),
            ("accel/kdtree/a.cpp", 'const char* kText = "nobody";  // a message is what users see\n'),
            ("docs/decisions/a.md", "A pencil of rays.\n"),
            ("docs/languages/node/node_modules/a/README.md", "Whoever installs this.\n"),
            ("docs/a.md", "As `nobody` says:\n\n    whoever\n\n```\nso many\n```\n[link](so-many.md)\n"),
        ]:
            self.assert_clean(words.check, file, text)

    def test_others_are_found(self):
        for file, text, wanted in [
            ("accel/kdtree/a.h", "int a;\n// Whoever asks is told.\n", 'a.h:2: "Whoever"'),
            ("accel/kdtree/a.h", "// Holds so\n// many of them.\n", 'a.h:1: "so many"'),
            ("accel/kdtree/a.h", "/* Waits while others are\n   at it. */\n", 'a.h:1: "are at it"'),
            ("accel/kdtree/a.h", "int f() {\n  return kPutAside;\n}\n", 'a.h:2: "kPutAside": say'),
            ("accel/kdtree/a.h", "int place = 0;\n", '"place"'),
            ("accel/kdtree/departed.h", "int index;\n", '"departed"'),
            ("tests/accel/a_test.cpp", "int mark_movers();\n", '"mark_movers"'),
            ("docs/a.md", "A pencil of rays.\n", 'a.md:1: "pencil": say packet'),
            ("accel/kdtree/a.h", "// A pencil of rays.\n", 'a.h:1: "pencil": say packet'),
            ("docs/decisions/a.md", "# A\n\nThat comes\nof it.\n", 'a.md:3: "comes of"'),
        ]:
            with self.subTest(text=text):
                self.assert_found(words.check, file, text, wanted)


class Links(Tree):
    def test_links_and_paths(self):
        self.write("docs/b.md", "# B\n")
        self.write("accel/kdtree/slot.h", "")
        self.assert_clean(links.check, "docs/a.md",
                          "[b](b.md#b), [c](https://example.org/c), `accel/kdtree/slot.h`, `a](b)`\n")
        self.assert_found(links.check, "docs/a.md", "\n[c](c.md) and `accel/kdtree/gone.h`\n",
                          "a.md:2: links to c.md", "names accel/kdtree/gone.h")

    def test_sections(self):
        self.write("docs/b.md", "# B\n## One, `two`\n## One, two\n```\n# Code\n```\n")
        self.assert_clean(links.check, "docs/a.md", "## Here\n[b](b.md#one-two), [b](b.md#one-two-1), [a](#here)\n")
        for link in ("b.md#one", "b.md#code", "b.md#one-two-2", "#there"):
            with self.subTest(link=link):
                self.assert_found(links.check, "docs/a.md", f"## Here\n[b]({link})\n", "a section that is gone")


class RayPath(Tree):
    PAGE = """# The life of a ray batch
`accel/kdtree`, `accel/lazy/` and `server`
## Rays in
`server/main.cpp`, `accel/kdtree/slot.{h,cpp}`, `accel/lazy/a.h`, slot.h
## An update
`server/main.cpp`, `accel/kdtree/slot.{h,cpp}`, `accel/lazy/a.h`, slot.h
## A build
`server/main.cpp`, `accel/kdtree/slot.{h,cpp}`
"""

    def setUp(self):
        super().setUp()
        for file in ("accel/kdtree/slot.h", "accel/kdtree/slot.cpp", "accel/lazy/a.h", "server/main.cpp"):
            self.write(file, "")

    def test_folders_and_walks(self):
        self.assert_clean(ray_path.check, "docs/ray_path.md", self.PAGE)
        for old, new, *wanted in [
            ("accel/lazy/a.h", "accel/lazy/b.h", "ray_path.md:4: accel/lazy/b.h", "ray_path.md:6: accel/lazy/b.h"),
            ("`accel/lazy/` ", "", "accel/lazy is not named"),
            ("# A build", "# A tree", "no walk of 'build'"),
            ("`accel/lazy/a.h`, slot.h\n## A build", "slot.h\n## A build", "no walk of 'update'"),
        ]:
            with self.subTest(new=new):
                self.assert_found(ray_path.check, "docs/ray_path.md", self.PAGE.replace(old, new), *wanted)
        self.assertEqual(ray_path.check(self.root), ["docs/ray_path.md does not exist"])


class Run(Tree):
    def test_findings_fail_the_run(self):
        run = [sys.executable, str(pathlib.Path(__file__).with_name("run")), "--root", str(self.root), "links"]
        self.assertEqual(subprocess.run(run, capture_output=True).returncode, 0)
        self.write("README.md", "[a](gone.md)\n")
        failed = subprocess.run(run, capture_output=True, text=True)
        self.assertEqual(failed.returncode, 1)
        self.assertIn("README.md:1: links to gone.md", failed.stdout)


class Sources(unittest.TestCase):
    TEXT = 'int a = 1\'000; // it\'s "x"\nauto b = "// no" R"(}{)"; /* c\n d */ char e = \'"\';\n#include "f//g.h"\n'

    def test_views_keep_lines_and_columns(self):
        for view in (sources.code(self.TEXT), sources.comments(self.TEXT)):
            self.assertEqual([len(line) for line in view.split("\n")], [len(line) for line in self.TEXT.split("\n")])

    def test_code_has_no_comments_and_comments_no_code(self):
        self.assertEqual(sources.code(self.TEXT).split(),
                         ["int", "a", "=", "1'000;", "auto", "b", "=", ";", "char", "e", "=", ";"])
        self.assertEqual(sources.comments(self.TEXT).split(), ["//", "it's", '"x"', "/*", "c", "d", "*/"])


if __name__ == "__main__":
    unittest.main()

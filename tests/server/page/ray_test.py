#!/usr/bin/env python3
"""A ray that is cast by hand on the live page: the answer's columns, and errors by their messages.

ray_test.py SIGHTLINED SIGHTLINE MODEL [--shots DIRECTORY]
"""

from page_case import PageCase, run_tests


class Ray(PageCase):
    def cast(self, origin, direction):
        for field, text in (("#origin", origin), ("#direction", direction)):
            self.find(field).clear()
            self.find(field).send_keys(text)
        self.find("#ray-form button").click()

    def refused(self, origin, direction, message):
        self.cast(origin, direction)
        self.until(lambda: message in self.text("#ray-state"))
        self.assertEqual(self.facts("#picked"), {})

    def test_1_the_columns_are_those_of_a_cast(self):
        self.open_scene()
        self.cast("0, 500, 0", "0 -1 0")
        self.until(lambda: "Node" in self.facts("#picked"))
        shown = self.facts("#picked")
        row = self.server.run("cast", "engine", "--in", "-", "--out", "-", "--fields", "t,node,primitive,u,v,nx,ny,nz",
                              stdin="0,500,0,0,-1,0\n").strip().split("\n")[-1].split(",")
        self.assertEqual([shown["t"], shown["Node"], shown["Primitive"]], row[:3])
        self.assertEqual([float(x) for x in shown["Barycentric"].split()], [float(x) for x in row[3:5]])
        self.assertEqual([float(x) for x in shown["Normal"].split()], [float(x) for x in row[5:8]])
        self.assertEqual([float(x) for x in shown["Position"].split()], [0, 500 - float(row[0]), 0])
        self.until(lambda: self.facts("#selected").get("Name") == shown["Name"])

    def test_2_a_miss_selects_nothing(self):
        self.open_scene()
        self.cast("0 5000 0", "0 1 0")
        self.until(lambda: self.facts("#picked") == {"Nothing": "is hit"})
        self.assertEqual(self.facts("#selected"), {})

    def test_3_what_is_no_ray_is_refused_by_name(self):
        self.open_scene()
        self.refused("0 abc 0", "0 -1 0", "origin: 'abc' is no number")
        self.assertEqual(self.find("#origin").get_attribute("aria-invalid"), "true")
        self.refused("0 0", "0 -1 0", "origin: 3 numbers are needed, x y z, not 2")
        self.refused("0 0 0", "0 1e999 0", "direction: 1e999 is beyond")
        self.assertIsNone(self.find("#origin").get_attribute("aria-invalid"))
        self.refused("0 0 0", "<b>" + "x" * 100, "'<b>" + "x" * 37 + "\u2026' is no number")
        self.refused("0 0 0", "0 0 0", "the server takes this ray as invalid")
        self.refused("1e300 0 0", "0 1 0", "the server takes this ray as invalid")
        self.assertEqual(self.errors(), [])
        self.check_accessible()

    def test_4_errors_of_the_service_are_shown_by_message(self):
        self.open_scene()
        self.server.run("scene", "rm", "engine")
        self.refused("0 500 0", "0 -1 0", "engine")
        self.assertEqual(self.find("#ray-state").get_attribute("class"), "bad")


if __name__ == "__main__":
    run_tests("rays of the page")

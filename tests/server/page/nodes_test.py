#!/usr/bin/env python3
"""The nodes on the live page: their tree, the search, the selection in both directions, and names that mean harm.

nodes_test.py SIGHTLINED SIGHTLINE MODEL [--shots DIRECTORY]
"""

import json

from page_case import PageCase, run_tests
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

HOSTILE = ("<img src=x onerror=document.title='gone'>", "\u202egnp.exe \u05d0\u05d1\u05d2", "x" * 1024, "Z\u0351\u036b\u0343" * 30,
           "\u2069\u2069\u202e out", "</script><script>document.title='gone'</script>", "")


class NodesCase(PageCase):
    def update(self, *updates):
        text = "\n".join(json.dumps(update) for update in updates)
        return json.loads(self.server.run("update", "engine", "--file", "-", "--in-parts", "--json", stdin=text))

    def open_nodes(self):
        self.open_scene()
        self.until(lambda: self.text("#nodes-state").endswith(" nodes"))

    def search(self, text):
        self.find("#find").clear()
        self.find("#find").send_keys(text)

    def found(self):
        return [one.text.split("\n")[0] for one in self.browser.find_elements(By.CSS_SELECTOR, "#found button bdi.name")]

    def row(self, node):
        return self.browser.execute_script("return document.getElementById(arguments[0])", f"node-{node}")

    def active(self):
        """The id of the row that the keyboard is at; 0: none."""
        return self.browser.execute_script("""
            const row = document.getElementById(document.getElementById('tree').getAttribute('aria-activedescendant'));
            return Number(row?.dataset.node ?? 0);""")

    def active_name(self):
        return self.browser.execute_script("return document.querySelector('#tree .active bdi')?.textContent ?? ''")


class Nodes(NodesCase):
    def setUp(self):
        self.open_nodes()

    def test_1_a_press_on_the_picture_selects_in_the_tree(self):
        ActionChains(self.browser).move_to_element(self.find("#picture")).click().perform()
        self.until(lambda: "pixels" in self.facts("#selected").get("In the picture", ""))
        node = self.facts("#picked")["Node"]
        self.assertEqual(self.facts("#selected")["Selected"], node)
        self.assertEqual(self.facts("#selected")["Name"], self.facts("#picked")["Name"])
        row = self.row(node)
        self.assertEqual(row.get_attribute("aria-selected"), "true")
        tree, box = self.find("#tree").rect, row.rect
        self.assertTrue(tree["y"] <= box["y"] <= tree["y"] + tree["height"])

    def test_2_the_tree_by_keyboard_selects_in_the_picture(self):
        tree = self.find("#tree")
        tree.send_keys(Keys.HOME)
        root = self.active()
        self.assertEqual(self.row(root).get_attribute("aria-level"), "1")
        if self.row(root).get_attribute("aria-expanded") == "false":
            tree.send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(self.row(root).get_attribute("aria-expanded"), "true")
        tree.send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(self.row(self.active()).get_attribute("aria-level"), "2")
        tree.send_keys(Keys.ARROW_LEFT)
        self.assertEqual(self.active(), root)
        outline = "return document.getElementById('outline').toDataURL()"
        before = self.browser.execute_script(outline)
        tree.send_keys(Keys.ENTER)
        self.until(lambda: "pixels" in self.facts("#selected").get("In the picture", ""))
        self.assertEqual(self.facts("#selected")["Selected"], str(root))
        self.assertNotEqual(self.browser.execute_script(outline), before)
        tree.send_keys(Keys.ARROW_LEFT)
        self.assertEqual(self.row(root).get_attribute("aria-expanded"), "false")
        tree.send_keys(Keys.ARROW_RIGHT)

    def test_3_search_finds_parts_of_names_in_any_case_and_ids(self):
        self.search("NODES[71")
        self.until(lambda: self.found() == ["nodes[71]"])
        self.assertEqual(self.text("#find-note"), "1 node")
        self.find("#find").send_keys(Keys.ARROW_DOWN, Keys.NULL)
        self.browser.switch_to.active_element.send_keys(Keys.ENTER)
        self.until(lambda: self.facts("#selected").get("Name") == "nodes[71]")
        self.search("26")
        self.until(lambda: self.browser.find_element(By.CSS_SELECTOR, "#found .id").text == "26")
        self.search("nodes")
        self.until(lambda: len(self.found()) == 50)
        self.assertIn("more: write more of the name", self.text("#find-note"))
        self.search(".*")  # it is text, no pattern
        self.until(lambda: self.text("#find-note") == "no node has this in its name")
        self.find("#find").send_keys(Keys.ESCAPE)
        self.assertEqual(self.find("#find").get_attribute("value"), "")

    def test_4_the_tree_follows_the_scene(self):
        node, child = self.update({"put_node": {"node": -1, "parent": 0, "name": "crane"}},
                                  {"put_node": {"node": -2, "parent": -1, "name": "hook"}})["nodes"]
        self.search("hook")
        self.until(lambda: self.found() == ["hook"])
        self.find("#found button").click()
        self.until(lambda: self.facts("#selected").get("Below") == "crane")
        self.until(lambda: self.facts("#selected")["In the picture"] == "not in view")
        self.update({"put_node": {"node": child, "parent": 0, "name": "hook of brass"}})
        self.until(lambda: self.facts("#selected")["Name"] == "hook of brass")
        self.assertEqual(self.facts("#selected")["Below"], "no node: it is a root")
        self.update({"put_node": {"node": child, "parent": node, "name": "hook"}})
        self.until(lambda: self.facts("#selected")["Below"] == "crane")
        self.update({"delete_node": {"node": node, "subtree": True}})
        self.until(lambda: self.facts("#selected") == {})
        self.assertEqual(self.text("#find-note"), "no node has this in its name")

    def test_5_hostile_names_are_text(self):
        made = self.update(*({"put_node": {"node": -1 - i, "parent": 0, "name": name}}
                             for i, name in enumerate(HOSTILE)))["nodes"]
        tree = self.find("#tree")
        for node, name in zip(made, HOSTILE):
            self.search(str(node))
            self.until(lambda node=node: self.text("#find-note") and self.browser.find_elements(
                By.CSS_SELECTOR, f"#found [data-node='{node}']"))
            self.find(f"#found [data-node='{node}']").click()
            self.until(lambda node=node: self.facts("#selected").get("Selected") == str(node))
            self.assertEqual(self.facts("#selected")["Name"], name or "no name")
            row = self.row(node)
            self.assertEqual(row.find_element(By.CSS_SELECTOR, "bdi").get_attribute("textContent"), name or "no name")
            self.assertLessEqual(row.rect["width"], tree.rect["width"])
            self.assertLessEqual(row.rect["height"], 28)
        for width in (1100, 360):
            self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
            self.search("x")
            self.until(self.found)
            self.shot(f"hostile-{width}")
            self.assertLessEqual(self.browser.execute_script("return document.documentElement.scrollWidth"), width)
            self.assertLessEqual(self.browser.execute_script("return document.getElementById('tree').scrollWidth"),
                                 self.find("#tree").rect["width"])
        self.assertEqual(self.browser.title, "Sightline")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "main img, main script"), [])
        self.assertEqual(self.errors(), [])
        self.check_accessible()


class ManyNodes(NodesCase):
    """A hundred thousand nodes below one."""

    def test_rows_in_view_alone_are_elements(self):
        [top] = self.update({"put_node": {"node": -1, "parent": 0, "name": "warehouse"}})["nodes"]
        for begin in (0, 50000):
            self.update(*({"put_node": {"node": -1 - i, "parent": top, "name": f"shelf {begin + i:05}"}}
                          for i in range(50000)))
        self.open_scene()
        self.until(lambda: self.text("#nodes-state") == "100 k nodes")
        self.search("SHELF")
        self.until(lambda: self.text("#find-note") == "50 nodes, and 99950 more: write more of the name")
        self.search("shelf 57321")
        self.until(lambda: self.found() == ["shelf 57321"])
        self.find("#found button").click()
        self.until(lambda: self.facts("#selected").get("Name") == "shelf 57321")
        row = self.row(self.facts("#selected")["Selected"])
        self.assertEqual(row.get_attribute("aria-posinset"), "57322")
        self.assertEqual(row.get_attribute("aria-setsize"), "100000")
        self.find("#tree").send_keys(Keys.END)
        self.until(lambda: self.active_name() == "shelf 99999")
        rows = self.browser.execute_script("return document.querySelectorAll('[role=treeitem]').length")
        self.assertLess(rows, 60)
        self.assertEqual(self.errors(), [])
        self.check_accessible()


if __name__ == "__main__":
    run_tests("nodes of the page")

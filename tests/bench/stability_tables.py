"""The tables of "Stability" in docs/robustness.md."""
import re

from bench_runs import print_table, show

DEFAULTS = ["scan-fast", "scan-one-axis", "scan-best"]
LETTERS = {"references": "r", "depth": "d", "touches": "t", "work": "w", "cells given up": "g"}


def unique(values):
    return list(dict.fromkeys(values))


def letters(text):
    return "".join(letter for bound, letter in LETTERS.items() if re.search(rf"(^|; ){bound} \d", text))


def sign(row):
    """What one cell of the overview says."""
    if row is None:
        return " "
    failed = "**" + letters(row["failures"]).upper() + "**" if row["failures"] else ""
    if row["wrong"]:
        failed = f"**{row['wrong']} wrong**"
    return failed + letters(row["failed_by_design"]) or "·"


def overview(rows, families, builders):
    cells = {(r["family"], r["builder"]): r for r in rows}
    print_table("Bounds that are not kept. " + ", ".join(f"{letter}: {bound}" for bound, letter in LETTERS.items()) +
                "; small: by design of the method, capital: a failure; ·: all kept",
                ["family"] + builders, [[f] + [sign(cells.get((f, b))) for b in builders] for f in families])


def defaults(rows, families):
    for builder in (b for b in DEFAULTS if any(r["builder"] == b for r in rows)):
        of = {r["family"]: r for r in rows if r["builder"] == builder}
        table = [[f, of[f]["triangles"], "yes" if of[f]["ok"] and not of[f]["failed_by_design"] else "no",
                  of[f]["references_per_triangle"], of[f]["max_depth"], of[f]["touches_per_triangle"],
                  of[f]["relative_time"], of[f]["steps_per_ray"], of[f]["tests_per_ray"], of[f]["relative_work"]]
                 for f in families if f in of]
        print_table(f"`{builder}`", ["family", "triangles", "bounds kept", "references / triangle", "depth", "touches / triangle",
                                     "time / compact", "steps / ray", "tests / ray", "work / exact sweep"], table)


def failures(rows):
    failed = [r for r in rows if not r["ok"]]
    if not failed:
        print("\nNo bound is broken but by design.")
        return
    print_table("Failures", ["family", "builder", "what"], [[r["family"], r["builder"], r["failures"]] for r in failed])


def explained(rows):
    """A line a reason: who, where, and the worst of it."""
    cases = []
    for row in rows:
        for part in filter(None, row["failed_by_design"].split("; ")):
            what, why = part.split(": ", 1)
            cases.append((why, row["builder"], row["family"], what))
    table = []
    for why in unique(c[0] for c in cases):
        of = [c for c in cases if c[0] == why]
        table.append([why, ", ".join(unique(f"`{c[1]}`" for c in of)), ", ".join(unique(c[2] for c in of))])
    print_table("Why methods fail by design", ["reason", "builders", "families"], table)


def print_all(bench, options):
    rows = bench.rows("stability", "--triangles", 3_000, "--threads", 2, "--repeat", options.repeat,
                      *(["--builders", ",".join(options.builder)] if options.builder else []))
    families, builders = unique(r["family"] for r in rows), unique(r["builder"] for r in rows)
    answers = sum(r["wrong"] for r in rows)
    print(f"\n{len(families)} families, {len(builders)} builders, full trees and growing ones: {show(answers)} answers wrong.")
    overview(rows, families, builders)
    defaults(rows, families)
    failures(rows)
    explained(rows)

"""Draws the charts of docs/planning.md from the CSV files of a folder."""
import sys

from costs import ROOT
from sweep import FULL, REPLICAS, UPDATES_S, ZIPF, smallest_fleets

sys.path.insert(0, str(ROOT / "tests/bench/plots"))
from csv_files import read_csv
from style import BLUE, GREEN, GREY, LIGHT, ORANGE, log_ticks, plt, save

COLOURS = {"round_robin": ORANGE, "hashing": BLUE, "bounded": GREEN}
MARKS = {"round_robin": "o", "hashing": "s", "bounded": "^"}
TITLES = {"round_robin": "round robin", "hashing": "hashing on the scene", "bounded": "hashing, load bounded"}
MOST = 1_000_000  # clients of the sweep's largest workload


def panels(count, title, height=4.3):
    figure, axes = plt.subplots(1, count, figsize=(4.4 * count, height), sharey=True, squeeze=False)
    figure.suptitle(title, x=0.01, ha="left", fontsize=12)
    for one in axes[0]:
        one.grid(color=LIGHT, lw=0.8)
        one.set_axisbelow(True)
    return figure, axes[0]


def finish(figure, folder, name, more=()):
    handles = [plt.Line2D([], [], color=COLOURS[policy], marker=MARKS[policy], ms=5, label=TITLES[policy]) for policy in COLOURS]
    figure.tight_layout(rect=(0, 0.07, 1, 0.99))
    figure.legend(handles=[*handles, *more], loc="lower center", ncol=len(handles) + len(more), frameon=False, fontsize=9)
    return save(figure, folder, name)


def line(axes, rows, policy, x, y):
    of = sorted((row for row in rows if row["policy"] == policy), key=lambda row: row[x])
    wide = policy == "hashing"  # seen below the line of the policy that is often the same
    axes.plot([row[x] for row in of], [row[y] for row in of], MARKS[policy] + "-", color=COLOURS[policy], ms=7 if wide else 4,
              lw=2.6 if wide else 1.3, alpha=0.6 if wide else 1)


def log_replicas(axes):
    axes.set_xscale("log")
    log_ticks(axes.xaxis, 1, max(REPLICAS), (1, 3))
    axes.set_xlabel("replicas")


def throughput(folder, rows):
    """Requests answered a second, when a million clients ask."""
    figure, axes = panels(len(ZIPF), "Requests answered a second, if a million clients ask for one each")
    for one, zipf in zip(axes, ZIPF):
        of = [row for row in rows if row["clients"] == MOST and row["zipf"] == zipf]
        for policy in COLOURS:
            line(one, of, policy, "replicas", "answered")
        one.axhline(of[0]["offered"], color=GREY, lw=0.9, ls=(0, (4, 3)))
        one.set_title(f"popularity: Zipf, exponent {zipf:g}", fontsize=10)
        log_replicas(one)
        one.set_yscale("log")
    axes[0].set_ylabel("requests answered a second")
    axes[0].text(1, 1.1 * MOST, "all requests", fontsize=8, color=GREY)
    finish(figure, folder, "planning_throughput")


def warm(folder, rows):
    """The share of the trees that requests need that is there."""
    counts = 1_000, 30_000, 1_000_000
    figure, axes = panels(len(counts), "Share of warm trees: of what requests need, what is built when they come (Zipf, exponent 1)")
    for one, clients in zip(axes, counts):
        for policy in COLOURS:
            line(one, [row for row in rows if row["clients"] == clients and row["zipf"] == 1], policy, "replicas", "warm_share")
        one.set_title(f"{clients:,} clients", fontsize=10)
        log_replicas(one)
        one.set_ylim(0, 1.02)
    axes[0].set_ylabel("share of warm trees")
    finish(figure, folder, "planning_warm")


def log_fanout(folder, rows):
    """PostgreSQL's load."""
    figure, axes = panels(len(UPDATES_S), "What updates and meshes cost PostgreSQL, with 300 clients a replica (1: all cores of its machine)")
    for one, updates in zip(axes, UPDATES_S):
        for policy in COLOURS:
            line(one, [row for row in rows if row["updates_s"] == updates], policy, "replicas", "database_load")
        one.axhline(1, color=GREY, lw=0.9, ls=(0, (4, 3)))
        one.set_title(f"{updates:,} updates a second", fontsize=10)
        log_replicas(one)
        one.set_yscale("log")
    axes[0].set_ylabel("cores needed / cores there")
    axes[0].text(1, 1.15, "no more updates", fontsize=8, color=GREY)
    finish(figure, folder, "planning_log")


def cost(folder, rows):
    """An hour of the smallest fleet that suffices."""
    figure, axes = panels(len(ZIPF), f"Cost an hour of the smallest fleet whose busiest replica is loaded to {100 * FULL:.0f} % at most")
    fleets = smallest_fleets(rows)
    for one, zipf in zip(axes, ZIPF):
        for policy in COLOURS:
            of = [row for (name, exponent, _), row in fleets.items() if name == policy and exponent == zipf]
            if of:
                line(one, of, policy, "clients", "cost_an_hour")
                last = max(of, key=lambda row: row["clients"])
                if last["clients"] < MOST:
                    one.plot(last["clients"], last["cost_an_hour"], "x", color=COLOURS[policy], ms=10, mew=2)
        one.set_title(f"popularity: Zipf, exponent {zipf:g}", fontsize=10)
        one.set_xscale("log")
        one.set_yscale("log")
        one.set_xlabel("clients, one request a second each")
    axes[0].set_ylabel("cost an hour")
    finish(figure, folder, "planning_cost", [plt.Line2D([], [], color=GREY, marker="x", ms=8, mew=2, ls="",
                                                        label="no fleet of 1,000 serves the next number")])


def agreement(folder, rows):
    """Steady state against events."""
    keys = ("warm_share", "share of warm trees"), ("mean_load", "mean load"), ("p50_ms", "median response, ms"), ("p99_ms", "99th percentile, ms")
    figure, axes = plt.subplots(1, len(keys), figsize=(3.5 * len(keys), 4.3))
    figure.suptitle("The steady state against the event simulation: 1 to 30 replicas with little memory; the band is a tenth", x=0.01, ha="left", fontsize=12)
    for one, (key, title) in zip(axes, keys):
        for policy in COLOURS:
            of = [row for row in rows if row["policy"] == policy]
            for load, filled in zip(sorted({row["warm_load"] for row in of}), ("white", COLOURS[policy])):
                some = [row for row in of if row["warm_load"] == load]
                one.plot([row[f"events_{key}"] for row in some], [row[f"steady_{key}"] for row in some], MARKS[policy],
                         mfc=filled, mec=COLOURS[policy], ms=6, zorder=3)
        _identity(one, [row[f"{who}_{key}"] for who in ("events", "steady") for row in rows], key.endswith("_ms"))
        one.set_title(title, fontsize=10)
        one.set_xlabel("event simulation")
    axes[0].set_ylabel("steady state")
    finish(figure, folder, "planning_events", [plt.Line2D([], [], color=GREY, marker="o", mfc="white", ls="", label="hollow: low load")])


def _identity(axes, values, logarithmic):
    """The line on which both are equal, and a tenth to either side."""
    low, high = (0.8 * min(values), 1.25 * max(values)) if logarithmic else (0, 1.1 * max(values))
    if logarithmic:
        axes.set_xscale("log")
        axes.set_yscale("log")
        for axis in axes.xaxis, axes.yaxis:
            log_ticks(axis, low, high, (1, 1.5, 2, 3, 5, 7))
    axes.plot([low, high], [low, high], color=GREY, lw=0.9, zorder=1)
    axes.fill_between([low, high], [0.9 * low, 0.9 * high], [1.1 * low, 1.1 * high], color=LIGHT, zorder=0)
    axes.set_xlim(low, high)
    axes.set_ylim(low, high)


def check(folder, rows):
    """Simulation against a real cluster."""
    keys = ("throughput", "requests a second"), ("built_ratio", "triangles built, over one server's"), ("p50_ms", "median response, ms")
    figure, axes = plt.subplots(1, len(keys), figsize=(4.4 * len(keys), 4.3))
    figure.suptitle("Three replicas on two cores: simulated and measured", x=0.01, ha="left", fontsize=12)
    for one, (key, title) in zip(axes, keys):
        for number, policy in enumerate(COLOURS):
            of = [row for row in rows if row["policy"] == policy]
            one.bar(number - 0.2, sum(row[f"simulated_{key}"] for row in of) / len(of), 0.36, color=COLOURS[policy], alpha=0.45)
            one.plot([number + 0.2] * len(of), [row[f"measured_{key}"] for row in of], MARKS[policy], color=COLOURS[policy], ms=6)
        one.set_xticks(range(len(COLOURS)), [TITLES[policy].replace(", ", ",\n").replace(" on ", "\non ") for policy in COLOURS], fontsize=9)
        one.set_ylim(0)
        one.set_title(title, fontsize=10)
        one.grid(axis="y", color=LIGHT, lw=0.8)
        one.set_axisbelow(True)
    figure.tight_layout(rect=(0, 0.07, 1, 0.99))
    handles = [plt.Line2D([], [], color=GREY, lw=8, alpha=0.45, label="simulated"), plt.Line2D([], [], color=GREY, marker="o", ls="", label="measured, one mark a run")]
    figure.legend(handles=handles, loc="lower center", ncol=2, frameon=False, fontsize=9)
    save(figure, folder, "planning_check")


def draw_all(folder):
    sweep_rows = read_csv(folder / "planning.csv")
    throughput(folder, sweep_rows)
    warm(folder, sweep_rows)
    cost(folder, sweep_rows)
    log_fanout(folder, read_csv(folder / "planning_log.csv"))
    agreement(folder, read_csv(folder / "planning_events.csv"))
    if (folder / "planning_check.csv").exists():
        check(folder, read_csv(folder / "planning_check.csv"))

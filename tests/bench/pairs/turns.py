"""Lets an old and a new program take turns over one experiment, and compares their answers."""
from programs import Failed
from quotients import gains, quartiles
from readings import OURS

OLD, NEW = "old", "new"


def check_same(first, answers, name):
    if answers != first[1]:
        raise Failed(f"answers differ: {first[0]} has {first[1]}, {name} has {answers}")


def read(program, experiment):
    rows = program.rows(experiment.words)
    try:
        return experiment.read(rows)
    except Failed as wrong:
        raise Failed(f"{program.command(experiment.words)}\n{wrong}") from None
    except (KeyError, IndexError) as missing:
        raise Failed(f"{program.command(experiment.words)}\nits rows have no {missing}") from None


def take_turns(programs, experiment, pairs):
    """The costs of all runs, by program, and the answers, which all runs share. Each program is first in every other pair."""
    costs, first = {name: [] for name in programs}, None
    for pair in range(pairs if experiment.timed else 1):
        for name in sorted(programs, key=(OLD, NEW).index, reverse=pair % 2 == 1):
            run_costs, answers = read(programs[name], experiment)
            first = first or (f"{name}, pair 1", answers)
            try:
                check_same(first, answers, f"{name}, pair {pair + 1}")
            except Failed as wrong:
                raise Failed(f"{programs[name].command(experiment.words)}\n{wrong}") from None
            costs[name].append(run_costs)
    return costs, first[1]


def compare(experiment, costs):
    """Rows, one for each quantity and each side that the new program is compared with."""
    rows = []
    for quantity, unit in costs[NEW][0]:
        side = lambda program, name: [run[quantity, unit][name] for run in costs[program]]
        ours = side(NEW, OURS)
        sides = {OLD: side(OLD, OURS)} if all((quantity, unit) in run for run in costs[OLD]) else {}
        sides |= {name: side(NEW, name) for name in costs[NEW][0][quantity, unit] if name != OURS}
        for over, theirs in sides.items():
            row = {"kind": experiment.kind, "scene": experiment.scene, "form": experiment.form, "rays": experiment.rays,
                   "threads": experiment.threads, "quantity": quantity, "unit": unit, "over": over, "pairs": len(ours)}
            for key, values in (("new", ours), ("theirs", theirs), ("gain", gains(theirs, ours))):
                if values is not None:
                    row[key], row[f"{key}_q1"], row[f"{key}_q3"] = quartiles(values)
            rows.append(row)
    return rows

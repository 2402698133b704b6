"""Readable tables of comparisons: one for each quantity and number of threads, a line a scene, form and kind of rays."""
from quotients import geometric_mean

KEY = "kind", "quantity", "unit", "threads"


def digits(value):
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def gain_text(row):
    if "gain" not in row:
        return "-"
    return f"{row['gain']:.2f} [{row['gain_q1']:.2f}, {row['gain_q3']:.2f}]"


def aligned(lines):
    """The first two columns to the left, figures to the right."""
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    return "\n".join("  ".join(cell.ljust(width) if column < 2 else cell.rjust(width)
                               for column, (cell, width) in enumerate(zip(line, widths))).rstrip() for line in lines)


def means(rows, sides):
    """A line for each form, or one if there are fewer than two. A row without a form counts for every form."""
    forms = list(dict.fromkeys(row["form"] for row in rows if row["form"]))
    for form in forms if len(forms) > 1 else [None]:
        counted = [row for row in rows if "gain" in row and (form is None or row["form"] in ("", form))]
        gains = {side: [row["gain"] for row in counted if row["over"] == side] for side in sides}
        yield ["geometric mean" if form is None else f"geometric mean, {form}", "", *[""] * (len(sides) + 1),
               *(f"{geometric_mean(of):.2f}" if of else "-" for of in gains.values())]


def table(rows):
    """Of one quantity and number of threads. The last lines have geometric means where there are several lines."""
    sides = list(dict.fromkeys(row["over"] for row in rows))
    subjects = {}
    for row in rows:
        subjects.setdefault((row["scene"], row["form"], row["rays"]), {})[row["over"]] = row
    lines = [["scene", "rays", *(f"{side}" for side in sides), "new", *(f"{side}/new" for side in sides)]]
    for (scene, form, rays), of in subjects.items():
        cost = lambda side: digits(of[side]["theirs"]) if side in of else "-"
        gain = lambda side: gain_text(of[side]) if side in of else "-"
        lines.append([f"{scene}, {form}" if form else scene, rays, *map(cost, sides), digits(next(iter(of.values()))["new"]),
                      *map(gain, sides)])
    if len(subjects) > 1:
        lines += means(rows, sides)
    return aligned(lines)


def heading(kind, quantity, unit, threads):
    name = quantity if quantity.startswith(kind) else f"{kind}: {quantity}"
    return f"{name}, {unit}, {threads} thread{'' if threads == 1 else 's'}"


def tables(rows):
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in KEY), []).append(row)
    return "\n\n".join(f"{heading(*key)}\n{table(of)}" for key, of in groups.items())

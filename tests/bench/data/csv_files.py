"""Reads and writes the CSV files of docs/data, and the record of how each was made."""
import csv
import datetime
import json

DIGITS = 4  # significant digits of what is not a whole number
PROVENANCE = "provenance.json"


def text_of(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{DIGITS}g}" if abs(value) < 10 ** DIGITS else f"{value:.0f}"
    return str(value)


def write_csv(path, rows):
    """One line a row; the columns are those of all rows, in the order in which they appear first."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(columns)
        out.writerows([text_of(row.get(column)) for column in columns] for row in rows)


def value_of(text):
    """A number if the text is one."""
    try:
        return float(text)
    except ValueError:
        return text


def read_csv(path):
    """The rows, without empty cells; numbers are floats."""
    with open(path, newline="") as file:
        return [{key: value_of(text) for key, text in row.items() if text != ""} for row in csv.DictReader(file)]


def read_provenance(folder):
    path = folder / PROVENANCE
    return json.loads(path.read_text()) if path.exists() else {}


def record(folder, names, bench, run):
    """Notes for each file which run made it: commit, machine, compiler, commands, seconds, load average."""
    known = read_provenance(folder)
    for name in names:
        known[name] = {**run, "date": datetime.date.today().isoformat(), "load_average": round(bench.load, 1),
                       "seconds": round(bench.seconds), "commands": bench.commands}
    (folder / PROVENANCE).write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")

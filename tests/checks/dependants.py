"""A change inside the trees compiles little: each header of accel has at most MOST dependants in the product, which are the
.cpp files that include it, directly or not. The vocabulary that every room speaks may have more: it includes nothing but
itself, so no header of a tree becomes visible with it."""

from sources import PRODUCT, cpp_files, includes, read

MOST = 60

# Headers, and folders with all headers in them.
VOCABULARY = (
    "accel/geometry/",             # boxes, rays, triangles
    "accel/kdtree/ref_counted.h",
    "accel/kdtree/reference.h",    # weighted boxes, which hierarchies of nodes are made of too
    "accel/kdtree/tree_memory.h",  # a limit that the server sets
    "accel/mesh/mesh_stats.h",
    "accel/mesh/tree_builder.h",   # what a mesh hands on to its tree
    "accel/split/split_rule.h",
)


def is_vocabulary(header):
    return header.startswith(VOCABULARY)


def reached(file, included):
    """All headers that a file includes, directly or not."""
    found, waiting = set(), [file]
    while waiting:
        for header in included.get(waiting.pop(), ()):
            if header in included and header not in found:
                found.add(header)
                waiting.append(header)
    return found


def check(root):
    included = {file: [header for _, header, _ in includes(read(root, file))] for file in cpp_files(root, PRODUCT)}
    dependants = dict.fromkeys(included, 0)
    for file in included:
        if file.endswith(".cpp"):
            for header in reached(file, included):
                dependants[header] += 1

    findings = []
    for header, count in dependants.items():
        if not header.startswith("accel/") or not header.endswith(".h"):
            continue
        if is_vocabulary(header):
            findings += [f"{header}: includes {other}, which is not in the vocabulary"
                         for other in included[header] if other.startswith("accel/") and not is_vocabulary(other)]
        elif count > MOST:
            findings.append(f"{header}: has {count} dependants, the limit is {MOST}: declare its types where they are only named")
    return findings

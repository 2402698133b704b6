"""Every #include goes down: from a room to rooms that stand above it in ROOMS, or to a package that it may use."""

import fnmatch

from sources import PRODUCT, cpp_files, includes, read

# A room, and the rooms that it may include. A room may only name rooms that stand above it, so there is no circle.
# A room is a folder with its files, but not its folders; or files: a pattern, or a path without its ending. The most
# specific room of a file counts.
ROOMS = """
proto/rays
proto/result
proto/printable

accel/geometry
accel/kdtree                accel/geometry
accel/blocks                accel/geometry accel/kdtree
accel/wide                  accel/geometry accel/kdtree accel/blocks
accel/split                 proto/result accel/geometry accel/kdtree
accel/grow                  accel/geometry accel/kdtree accel/blocks accel/wide accel/split
accel/lazy                  accel/geometry accel/kdtree accel/blocks accel/wide accel/split accel/grow
accel/mesh                  accel/geometry accel/kdtree accel/blocks accel/wide accel/split accel/grow accel/lazy
accel/published/kd          accel/*
accel/published/bvh         accel/*
accel/published             accel/* proto/result

scenegraph/model            proto/result accel/geometry accel/kdtree accel/lazy accel/mesh
scenegraph/hierarchy        scenegraph/model
scenegraph/instances        scenegraph/model scenegraph/hierarchy
                            proto/result accel/geometry accel/kdtree accel/wide accel/lazy accel/mesh
scenegraph/revision         scenegraph/model scenegraph/hierarchy scenegraph/instances
                            proto/result accel/kdtree accel/lazy accel/mesh
scenegraph/trace_options    accel/geometry accel/lazy
scenegraph/side_rule        accel/geometry
scenegraph/query            scenegraph/model scenegraph/instances scenegraph/revision scenegraph/trace_options
                            scenegraph/side_rule
                            proto/result accel/geometry accel/kdtree accel/wide accel/lazy accel/mesh
scenegraph/trace            scenegraph/* proto/result accel/geometry accel/kdtree
scenegraph/*.h              scenegraph/revision scenegraph/trace_options scenegraph/side_rule proto/result accel/geometry
scenegraph/query/normal_sides
                            scenegraph/* proto/result accel/geometry
scenegraph/*.cpp            scenegraph/* proto/result accel/geometry
scenegraph/scene            scenegraph/* proto/result accel/geometry

server/exec                 proto/result proto/printable accel/kdtree
server/net/descriptor
server/net                  server/net/descriptor server/exec proto/result
server/segments             server/exec server/net server/net/descriptor proto/result
server/settings             server/exec proto/result
server/metrics              server/exec scenegraph/trace_options proto/result
server/admin                server/exec server/net server/net/descriptor proto/result proto/printable
server/security             server/exec proto/result
server/blobs/digest         server/exec proto/result
server/store                server/exec server/net/descriptor server/blobs/digest proto/result
server/store/postgres       server/store server/exec server/net/descriptor server/blobs/digest proto/result
server/blobs                server/exec server/store server/blobs/digest
                            scenegraph/model proto/result accel/geometry
server/codec                server/exec server/blobs server/blobs/digest scenegraph/model proto/result
server/scenes               server/exec server/metrics server/store server/blobs server/blobs/digest server/codec
                            scenegraph/scene scenegraph/trace_options scenegraph/model scenegraph/instances
                            scenegraph/revision proto/result accel/kdtree
server/shards               server/exec server/net scenegraph/query scenegraph/revision scenegraph/trace_options scenegraph/side_rule
                            proto/result proto/printable accel/geometry
server/updates              server/exec server/store server/blobs server/blobs/digest server/codec server/scenes scenegraph/* proto/result
server/queries              server/exec server/metrics server/scenes server/segments server/shards server/updates scenegraph/* proto/result accel/geometry proto/rays
server/durable              server/exec server/store server/store/postgres server/blobs server/blobs/digest server/codec server/scenes
                            server/updates scenegraph/* proto/result
server                      server/* scenegraph/* proto/result proto/printable accel/split

client/*.h                  proto/rays proto/result
client/importer/sandbox     client/*.h
client/importer/*.h         client/*.h
client/importer/formats     client/*.h client/importer/*.h
client/importer/gltf        client/*.h client/importer/*.h
client/importer             client/*.h client/importer/*.h client/importer/sandbox client/importer/formats client/importer/gltf
client/wire                 client/*.h proto/rays
client/calls                client/*.h client/wire client/importer/*.h proto/rays proto/printable
client/*.cpp                proto/rays client/*.h client/wire client/calls client/importer/*.h
client/cli                  client/*.h
client/cli/files            client/*.h client/cli
client/cli/picture          client/*.h client/cli
client/cli/playback         client/*.h client/cli client/importer/*.h
client/cli/reference        client/*.h client/cli
client/cli/scene_files      client/*.h client/cli client/importer/*.h
client/load                 client/*.h client/cli/picture
client/load/report          client/*.h client/load
client/cli/verbs            client/*.h client/cli client/cli/* client/importer/*.h client/load client/load/report
client/cli/program          client/*.h client/cli client/cli/*
client/cli/main             client/cli/program
"""

# Messages, generated from proto.
MESSAGES = ("sightline/v1/", "sightline/page/v1/", "sightline/stored/v1/", "google/rpc/")
MESSAGE_USERS = ("server", "client/*.h", "client/*.cpp", "client/calls", "client/wire")

# A package, by how its headers begin, and who may include them: rooms with what is in them.
PACKAGES = """
tbb             accel scenegraph server
oneapi          accel scenegraph server
hwy             accel
fmt             proto server client
spdlog          server
prometheus      server
boost           server/admin accel/geometry
grpc            server client/*.cpp client/calls client/wire
grpcpp          server client/*.cpp client/calls client/wire
google/protobuf server client/calls client/wire
openssl         server client/*.cpp
sqlite3.h       server/store
libpq-fe.h      server/store/postgres
CLI             server client/cli
toml++          server/security server/settings
nlohmann        server client/cli client/importer client/load
png.h           client/cli/picture
assimp          client/importer
draco           client/importer/gltf
meshoptimizer.h client/importer/gltf
seccomp.h       client/importer/sandbox
"""

# Headers of POSIX: like the standard library's they have no folder, or one of these.
SYSTEM_FOLDERS = ("sys", "netinet", "arpa", "linux")


def parse(table):
    rows = {}
    name = None
    for line in table.splitlines():
        words = line.split()
        if words and not line.startswith(" "):
            name, *words = words
            rows[name] = []
        if words:
            rows[name] += words
    return rows


def room_of(file, rooms):
    """The most specific room that a file is in, or None."""
    folder, stem = file.rsplit("/", 1)[0], file.rsplit(".", 1)[0]
    if stem in rooms:
        return stem
    for room in rooms:
        if "*" in room and fnmatch.fnmatchcase(file, room) and file.count("/") == room.count("/"):
            return room
    return folder if folder in rooms else None


def covers(pattern, room):
    """Whether a room is meant by an entry of the table: the room itself, or all that begin as in folder/*."""
    return pattern == room or (pattern.endswith("/*") and room.startswith(pattern[:-1]))


def uses(entry, room):
    """Whether a room may use a package by an entry: the room itself, or one inside it."""
    return room == entry or room.startswith(entry + "/")


def circles(rooms):
    """Entries that name a room which does not stand above them."""
    above = []
    for room, allowed in rooms.items():
        for entry in allowed:
            if not any(covers(entry, other) for other in above):
                yield f"the table lets {room} include {entry}, which does not stand above it"
        above.append(room)


def reason(room, header, quoted, rooms, packages):
    """Why a file of a room may not include a header, or None."""
    if header.startswith(MESSAGES):
        return None if any(uses(user, room) for user in MESSAGE_USERS) else "only " + ", ".join(MESSAGE_USERS) + \
            " may see messages"
    top = header.split("/")[0]
    if top in PRODUCT:
        other = room_of(header, rooms)
        if other is None:
            return "its folder is not in the table of rooms"
        above = list(rooms)[:list(rooms).index(room)]
        if other == room or (other in above and any(covers(entry, other) for entry in rooms[room])):
            return None
        return f"{room} may not include {other}"
    if top in ("tests", "proto", "docs", "deploy"):
        return "nothing may include it"
    for package, users in packages.items():
        if header == package or header.startswith(package + "/"):
            return None if any(uses(user, room) for user in users) else \
                f"only {', '.join(users)} may use this package"
    if quoted:
        return "paths start at the root of the repository"
    if "/" in header and top not in SYSTEM_FOLDERS:
        return "a package that is not in the table"
    return None


def check(root):
    rooms, packages = parse(ROOMS), parse(PACKAGES)
    findings = list(circles(rooms))
    for file in cpp_files(root, PRODUCT):
        room = room_of(file, rooms)
        if room is None:
            findings.append(f"{file}: its folder is not in the table of rooms")
            continue
        for line, header, quoted in includes(read(root, file)):
            why = reason(room, header, quoted, rooms, packages)
            if why:
                findings.append(f"{file}:{line}: includes {header}: {why}")
    return findings

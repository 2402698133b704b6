// sightline nearest: reads points, and writes the face nearest to each.
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/verbs/query_verb.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

constexpr const char* kNearestFooter =
    R"(Without --in and --out, nearest is a filter: points on standard input, answers on standard output. An answer goes
out as soon as its point came; where points come fast, many go together. All are answered at one revision, but after
5 seconds without a point the newest one answers.

Points are x y z, and max if each has a greatest distance of its own:
  .csv .txt      a line a point, parted by commas or blanks, with or without a line of names first
  .ndjson .jsonl [x, y, z] a line, or {"position": [..], "max": ..}
  .npy           (..., 3) or (..., 4) of any real type
  .npz           the same as points, or positions (..., 3), and max
  .ply           vertices with x y z, and max
  -              standard input, any of these
A face at exactly the greatest distance counts; below 0 none does.

Answers are in the format of FILE's suffix, or of --out-format: arrays with named fields (.npy) in the shape of
the points, an array a field (.npz), points with fields (.ply, without those that have no face), else a line an
answer. There is a row a point; --kind all has a row a face, nearest first, none for a point without one, and one
with distance = nan for a point that is invalid, or distance = -inf for one without an answer.
  point      u8  number of the point, from 0 (--kind all)
  distance   f8  in scene coordinates, exact and rounded once; inf: no face, nan: an invalid point, -inf: a point
                 without an answer (--time-budget, --allow-partial); in JSON all three are null
  node       u8  0: no face
  primitive  u4  the face's number in its mesh; of several at the same distance the first node's first
  u v        f4  weights of vertices 1 and 2 at the nearest point
  x y z      f8  the nearest point of the face, in scene coordinates; nan without a face; in .ply nearest_x and so on
  nx ny nz   f4  unit normal of the face; 0 if it has no area
  name           of the node; only in csv and ndjson
  signed     f8  the distance, negative inside; 0 has no sign; inf, nan and -inf as in distance
  inside     u1  0 outside, 1 inside, 2 an invalid point, 4 no answer
  votes      u1  of --side-rays, those that say inside; neither 0 nor all: the surface has a hole there
  hit        u1  0 no face, 1 a face, 2 an invalid point (all that --kind any answers);
                 3 a face, and there are more than --max-hits; 4 no answer (--time-budget, --allow-partial)
  work       u4  steps and triangle tests, only if asked for
  count      u4  faces within the greatest distance (all that --kind count answers); 4294967295: invalid;
                 4294967294: no answer

Sides do not depend on the greatest distance, and only --kind closest has them; with no other fields
than inside and votes, no distance is computed. Which --side suits which mesh:
  parity   closed, whatever its windings
  winding  closed parts that overlap, whose windings agree: inside where one of them is
  normal   not closed, as a terrain or a wall: behind the face that is nearest
A mesh with small holes needs parity or winding and --side-rays of 7 or more.

Examples:
  sightline nearest engine --in scan.ply --out deviations.ply
  echo 0 500 0 | sightline nearest engine
  sightline nearest engine --in points.npy --out near.npy --max-distance 0.05
  sightline nearest engine --in points.csv --fields distance,name
  sightline nearest engine --in points.npy --out neighbours.npz --kind all --max-hits 8
  sightline nearest engine --in points.npy --out overlaps.npz --kind all --max-distance 0.1
  sightline nearest engine --in points.csv --fields signed,inside
  sightline nearest scan --in points.npy --out inside.npy --fields inside,votes --side-rays 15
  sightline nearest terrain --in points.csv --fields signed --side normal
  sightline nearest cell --in tool.npy --out clearance.npy --exclude robot
  track-tool | sightline nearest cell --out-format ndjson --quiet | use-distances)";

}  // namespace

void add_nearest_verb(CLI::App& program, Session& session) {
  CLI::App& verb =
      *program.add_subcommand("nearest", "Find the faces nearest to points, and their distances");
  const auto arguments = std::make_shared<QueryArguments>();
  arguments->asked = files::RowKind::kPoints;
  add_query_flags(verb, *arguments);
  verb.footer(kNearestFooter);
  verb.callback([&session, arguments] { session.exit = run_query(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs

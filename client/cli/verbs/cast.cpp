// sightline cast: casts rays from a file or a program, and writes what they hit.
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/verbs/query_verb.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

constexpr const char* kCastFooter =
    R"(Without --in and --out, cast is a filter: rays on standard input, hits on standard output. A hit goes out
as soon as its ray came; where rays come fast, many go together. All are answered at one revision, but after
5 seconds without a ray the newest one answers.

Rays are ox oy oz dx dy dz, and tmin tmax if each has its own:
  .csv .txt      a line a ray, parted by commas or blanks, with or without a line of names first
  .ndjson .jsonl [ox, oy, oz, dx, dy, dz] a line, or {"origin": [..], "direction": [..], "tmin": .., "tmax": ..}
  .npy           (..., 6) or (..., 8) of any real type
  .npz           the same as rays, or origins and directions (..., 3), and tmin and tmax
  .ply           vertices with x y z and nx ny nz, or with the names above
  -              standard input, any of these
Far from the origin float32 is too coarse for the rays of a small scene; a warning says so.
Hits are in the format of FILE's suffix, or of --out-format: arrays with named fields (.npy) in the shape of
the rays, an array a field (.npz), points with fields (.ply, without the misses), else a line a hit. There is
a row a ray; --kind all has a row a hit, nearest first, none for a miss, and one with t = nan for a
ray that cannot be cast, or t = -inf for one without an answer.
  ray        u8  number of the ray, from 0 (--kind all)
  t          f8  in lengths of the direction; inf: a miss, nan: a ray that cannot be cast, -inf: a ray without an
                 answer (--time-budget, --allow-partial); in JSON all three are null
  node       u8  0: a miss
  primitive  u4  the face's number in its mesh
  u v        f4  weights of vertices 1 and 2
  nx ny nz   f4  unit normal in scene coordinates
  hit        u1  0 miss, 1 hit, 2 a ray that cannot be cast (all that --kind any answers);
                 3 hit, and there are more than --max-hits; 4 no answer (--time-budget, --allow-partial)
  work       u4  steps and triangle tests, only if asked for
  count      u4  hits of the ray (all that --kind count answers); 4294967295: cannot be cast; 4294967294: no answer

Examples:
  sightline cast engine --in rays.npy --out hits.npy
  echo 0 500 0 0 -1 0 | sightline cast engine
  sightline cast engine --in rays.csv --fields t,node
  sightline cast engine --in sun.npy --out shadow.npy --kind any --json
  sightline cast engine --in rays.npy --out hits.npy --build full
  sightline cast engine --in rays.npy --out through.npz --kind all --max-hits 1000 --cull back
  sightline cast engine --in points.npy --out inside.npy --kind count --under piston --exclude 13 14
  make-rays | sightline cast engine --out-format ndjson --quiet | use-hits)";

}  // namespace

void add_cast_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("cast", "Cast rays and write what they hit");
  const auto arguments = std::make_shared<QueryArguments>();
  add_query_flags(verb, *arguments);
  verb.footer(kCastFooter);
  verb.callback([&session, arguments] { session.exit = run_query(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs

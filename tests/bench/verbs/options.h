// The command line's options, as the verbs take them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenegraph/revision/levels.h"
#include "scenegraph/trace.h"
#include "tests/bench/scenes/ray_kinds.h"
#include "tests/support/large_scene.h"

namespace sightline::bench {

struct CommonOptions {
  std::string scene;  ///< What was given: a file or gen:NAME?...
  int threads = 1;
  int repeat = 3;
  std::uint64_t seed = 1;
  std::string policy;            ///< "first-touch", "demand", "full", or empty: the verb's default.
  std::string rotate;            ///< "x,y,z" in degrees, or empty.
  bool merge = false;            ///< All instances as one mesh.
  std::vector<std::string> set;  ///< "key=value" for the builder.
  std::string simd;              ///< A target of Highway, as "AVX2"; empty: the best.
  bool json = false;
};

struct RayOptions {
  std::string kind{};
  std::size_t count = 0;
};

struct RaysOptions {
  RayOptions rays{};
  std::string out{};
};

struct BuildOptions {
  std::vector<std::string> builders{};
  bool end_points =
      false;  ///< Hierarchies' end-point overlap, too, which takes longer than building.
};

struct TraceOptions {
  std::vector<std::string> builders{};
  RayOptions rays{};
  scenegraph::QueryKind kind = scenegraph::QueryKind::kClosest;
  bool columns = false;  ///< Rays and hits in columns, not in arrays of structs.
};

struct LazyOptions {
  RayOptions rays{};
  std::vector<std::string> modes{"lazy", "full"};
  std::string builder{};
  std::string hierarchy{"runs"};  ///< How mesh trees begin: soup, runs.
  std::size_t batch = 0;          ///< Rays a batch; 0: all in one.
};

struct CompetitiveOptions {
  std::vector<std::string> kinds{"closeup", "random", "diffuse"};
  bool points = false;                ///< Nearest faces of points: near, volume and far.
  std::size_t measured = 10'000'000;  ///< Larger counts of rays by unit costs.
  std::size_t most = 100'000'000;
  double longest =
      120;  ///< Seconds of a count of rays, of all policies; longer ones by unit costs.
  std::size_t batch = 8192;
};

struct BudgetOptions {
  std::vector<std::string> kinds{"closeup", "random"};
  double share = 0.25;         ///< The share of the bytes of full trees.
  double seconds = 60;         ///< The time of casting, for each kind.
  std::size_t rays = 100'000;  ///< The rays of a set; sets take turns.
  std::size_t batch = 8192;
};

struct LawOptions {
  bool nodes = false;  ///< Measures the law of hierarchies: touches over nodes.
  /// Exponents of two of the triangles; nothing: those that the law is stated for.
  std::optional<int> min_n{}, max_n{};
  int least_share = 10;                    ///< Windows see 2^-least_share of the scene, up to all.
  std::size_t windows = 16;                ///< For each share; medians are reported.
  std::vector<std::string> hierarchies{};  ///< soup, runs; empty: both, or runs with `nodes`.
  std::string builder{};
};

struct KernelOptions {
  std::vector<std::size_t> boxes{32'768, 4'194'304};  ///< One list each: within L2, and beyond L3.
};

struct ExactnessOptions {
  std::vector<std::string> kinds{"overview", "diffuse", "random"};
  std::size_t count = 1'000'000;
  std::string builder{};
};

struct NearestOptions {
  std::vector<std::string> kinds{"near", "volume", "far"};
  std::size_t count = 100'000;  ///< The number of points of each kind.
  bool sorted = false;          ///< Points that follow each other are near each other.
};

struct LazyPointsOptions {
  std::vector<std::size_t> counts{1, 100, 10'000, 100'000};
  std::size_t spot = 10'000;
  std::size_t cold = 31;
};

struct CheckOptions {
  std::string family{};            ///< Families whose name begins with this; empty: all.
  std::size_t points = 1'000'000;  ///< Of all families together.
};

struct RobustOptions {
  std::string family{};                 ///< Families whose name begins with this; empty: all.
  int level = 7;                        ///< The level of the icospheres.
  std::size_t count = 1'000'000;        ///< For each family, a quarter of each kind.
  std::vector<std::string> builders{};  ///< Empty: all but sah-naive.
};

struct StabilityOptions {
  std::string family{};                 ///< Families whose name begins with this; empty: all.
  std::uint64_t triangles = 10'000;     ///< The number in each family, approximately.
  std::size_t rays = 400;               ///< For each family.
  std::vector<std::string> builders{};  ///< Empty: all of ours.
};

struct ClusterOptions {
  std::string kind{};                 ///< Empty: all.
  std::uint64_t triangles = 30'000;   ///< The number of each kind.
  std::size_t rays = 60;              ///< For each kind.
  std::string builder = "scan-fast";  ///< One of ours.
};

struct AnswersOptions {
  std::vector<std::string> kinds{"random", "aimed"};
  std::size_t count = 10'000;           ///< The number of each kind.
  std::vector<std::string> builders{};  ///< Empty: all, but for sah-naive on large scenes.
};

struct DynamicOptions {
  std::string frames{};  ///< A directory of meshes of one topology, or gen:swarm?...
  std::size_t copies = 1;
  std::string static_scene{};        ///< The static part; empty: none.
  std::string small_static_scene{};  ///< For comparison: the same frames are played over this one.
  RayOptions rays{};
  bool shadow = false;               ///< Traces a ray toward a light from every hit.
  std::string view{"scene"};         ///< What the view shows: scene, frames.
  std::size_t length = 0;            ///< Frames to play; 0: each once.
  std::vector<std::string> peers{};  ///< embree-low, embree-refit
};

struct TwoTreesOptions {
  RayOptions rays{};
  std::size_t parts = 500;  ///< Number of parts in the scene.
};

struct UpdatesOptions {
  std::vector<std::size_t> nodes{1'000, 100'000, 1'000'000};  ///< Nodes with a mesh in the scene.
  std::size_t items = 100;  ///< Nodes that the larger batches name.
};

struct ScatteredOptions {
  tests::LargeScene scene{};
  std::size_t moving = 1000;    ///< Nodes that a revision moves.
  std::string moved{"random"};  ///< same, random
  std::size_t revisions = 300;
  std::size_t casts = 4;   ///< After each revision.
  std::size_t rays = 256;  ///< The number of rays in a cast.
  std::size_t warm = 200;  ///< Casts before the first revision.
  std::vector<std::uint64_t> small_trees{scenegraph::revision::MergeRule{}.small_tree};
  std::vector<std::uint64_t> at_once{scenegraph::revision::MergeRule{}.at_once};
};

struct RemoteOptions {
  RayOptions rays{};
  int clients = 1;           ///< Each with a connection and a stream of its own.
  std::size_t batch = 8192;  ///< Rays of a message.
  std::vector<std::string> columns{"rich", "t", "bits", "generated"};
  bool points = false;    ///< Asks for the faces nearest to the rays' origins; none are generated.
  bool segments = false;  ///< By one client, through memory that it shares with the server.
  bool echo = false;      ///< And the latency of one ray, beside an echo service.
};

struct TickOptions {
  std::size_t agents = 50;
  std::size_t rays = 200;
  std::size_t ticks = 600;
  double rate = 30;  ///< A second.
};

struct ChartOptions {
  std::string out{};                  ///< The folder of the CSV and the plots.
  std::vector<std::string> scenes{};  ///< Empty: six from SIGHTLINE_SCENES.
  bool quick = false;                 ///< Few rays: only shows that the study runs.
};

struct CurveOptions {
  char axis = 'x';
  int points = 500;  ///< Resolution of the curves.
};

}  // namespace sightline::bench

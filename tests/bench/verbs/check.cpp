// check: answers of points against the oracle, over all families, states of trees, SIMD targets,
// numbers of threads and sizes of batches.
#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "tests/bench/verbs/stopwatch.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/support/point_families.h"
#include "tests/support/point_ways.h"

namespace sightline::bench {
namespace {

using scenegraph::QueryKind;
using tests::CheckedPoints;
using tests::kTreeStates;
using tests::PointFamily;
using tests::PointWay;
using tests::TreeState;

// Points that are asked of the same fresh trees.
constexpr std::size_t kChunk = 8192;

struct FamilyCheck {
  tests::PointComparison compared;
  std::size_t points = 0, chunks = 0;
  std::uint64_t ties = 0;
  double oracle_seconds = 0, seconds = 0;
};

class Check {
 public:
  Check(const PointFamily& family, std::size_t number)
      : family_(family),
        number_(number),
        parts_(family.make()),
        scene_(parts_),
        oracle_(scene_.snapshot()) {}

  void add(std::uint64_t seed, std::size_t count, FamilyCheck& sum) {
    CheckedPoints points{family_.points(*scene_.snapshot(), seed, count), {}};
    points.nearest.resize(points.at.size());
    const Stopwatch oracle_clock;
    tbb::parallel_for(std::size_t{0}, points.at.size(), [&](std::size_t i) {
      points.nearest[i] = oracle_.all_closest(points.at[i], accel::geometry::kInfinity);
    });
    sum.oracle_seconds += oracle_clock.seconds();
    for (const auto& nearest : points.nearest) sum.ties += nearest.size();
    const Stopwatch clock;
    for (std::size_t state = 0; state < kTreeStates; ++state) {
      // Families begin with other ways, so that few chunks of each have most of them.
      const std::size_t round = sum.chunks + 7 * number_;
      PointWay way = tests::point_way(round * kTreeStates + state);
      sum.compared += compare_points(parts_, points, way);
      const bool is_complete = way.state != TreeState::kBuiltOnly;
      way.kind = is_complete ? static_cast<QueryKind>(1 + (round + state) % 3) : QueryKind::kAny;
      sum.compared += compare_points(parts_, points, way);
    }
    sum.seconds += clock.seconds();
    sum.points += points.at.size();
    ++sum.chunks;
  }

 private:
  const PointFamily& family_;
  const std::size_t number_;
  const std::vector<tests::ScenePart> parts_;
  const tests::FreshScene scene_;
  const tests::BruteNearest oracle_;
};

Row row_of(std::string_view name, const FamilyCheck& check) {
  Row row;
  row["family"] = name;
  row["points"] = check.points;
  row["nearest_faces"] = check.ties;
  row["checked"] = check.compared.checked;
  row["mismatches"] = check.compared.mismatches;
  row["oracle_seconds"] = check.oracle_seconds;
  row["seconds"] = check.seconds;
  return row;
}

}  // namespace

Result<std::vector<Row>> run_check(const CommonOptions& common, const CheckOptions& options) {
  std::vector<const PointFamily*> families;
  double shares = 0;
  for (const PointFamily& family : tests::point_families()) {
    if (!family.name.starts_with(options.family)) continue;
    families.push_back(&family);
    shares += family.share;
  }
  if (families.empty())
    return Error{Code::kInvalidArgument, "no family \"" + options.family + "\"", "COMMAND_LINE"};
  std::vector<Row> rows;
  FamilyCheck all;
  std::string examples;
  for (std::size_t f = 0; f < families.size(); ++f) {
    const PointFamily& family = *families[f];
    const auto count = static_cast<std::size_t>(
        std::max(1.0, static_cast<double>(options.points) * family.share / shares));
    Check check(family, f);
    FamilyCheck sum;
    for (std::size_t first = 0; first < count; first += kChunk)
      check.add(common.seed + first / kChunk * 1000 + f, std::min(kChunk, count - first), sum);
    rows.push_back(row_of(family.name, sum));
    all.compared += sum.compared;
    all.points += sum.points;
    all.ties += sum.ties;
    all.oracle_seconds += sum.oracle_seconds;
    all.seconds += sum.seconds;
    for (const std::string& example : sum.compared.examples)
      examples += fmt::format("\n{}: {}", family.name, example);
  }
  rows.push_back(row_of("all", all));
  if (all.compared.mismatches == 0) return rows;
  return Error{Code::kDataLoss, "answers differ from the oracle's\n" + to_table(rows) + examples,
               "WRONG_ANSWER"};
}

}  // namespace sightline::bench

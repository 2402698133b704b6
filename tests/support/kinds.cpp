// Compares the kinds of query with each other and with the oracle.
#include "tests/support/kinds.h"

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using scenegraph::RayTally;

constexpr std::size_t kMaxExamples = 5;

auto key(const Hit& hit) { return std::tuple(hit.t, hit.node, hit.primitive); }

bool same(const Hit& a, const Hit& b) {
  return key(a) == key(b) && a.u == b.u && a.v == b.v && a.normal == b.normal;
}

const char* contradiction_of(const Hit& closest, const Hit& any, const RayTally& count,
                             const RayTally& list, std::span<const Hit> listed,
                             std::uint32_t max_hits) {
  if (closest.state != any.state || closest.state != count.state || closest.state != list.state)
    return "states differ";
  if (closest.state == HitState::kInvalid) {
    const bool marked = count.count == scenegraph::kInvalidCount && listed.empty();
    return marked ? nullptr : "an invalid ray is not marked";
  }
  if ((closest.state == HitState::kHit) != std::isfinite(closest.t)) return "t against state";
  if ((count.count > 0) != std::isfinite(closest.t)) return "count against closest";
  if (list.cut_off != (count.count > max_hits)) return "cut off against count";
  if (listed.size() != std::min(count.count, max_hits)) return "list against count";
  if (!listed.empty() && !same(listed[0], closest)) return "list against closest";
  for (std::size_t i = 1; i < listed.size(); ++i) {
    if (!(key(listed[i - 1]) < key(listed[i]))) return "list out of order, or with a twin";
  }
  return nullptr;
}

const Candidate* find(const Hit& hit, const Reference& reference) {
  for (const Candidate& c : reference.candidates) {
    if (c.node == hit.node && c.primitive == hit.primitive) return &c;
  }
  return nullptr;
}

bool holds(std::span<const Hit> hits, const Candidate& c) {
  return std::any_of(hits.begin(), hits.end(), [&](const Hit& hit) {
    return hit.node == c.node && hit.primitive == c.primitive;
  });
}

}  // namespace

KindAnswers ask_all_kinds(const scenegraph::revision::Snapshot& snapshot,
                          std::span<const accel::geometry::Ray> rays,
                          scenegraph::TraceOptions options) {
  KindAnswers answers;
  answers.closest.resize(rays.size());
  answers.any.resize(rays.size());
  answers.counts.resize(rays.size());
  answers.lists.resize(rays.size());
  options.kind = scenegraph::QueryKind::kClosest;
  bool ok = static_cast<bool>(scenegraph::trace(snapshot, rays, answers.closest, options));
  options.kind = scenegraph::QueryKind::kAny;
  ok = scenegraph::trace(snapshot, rays, answers.any, options) && ok;
  ok = scenegraph::count_hits(snapshot, rays, answers.counts, options) && ok;
  ok = scenegraph::list_hits(snapshot, rays, answers.lists, answers.listed, options) && ok;
  return ok ? answers : KindAnswers{};
}

std::string contradiction(const KindAnswers& answers, std::uint32_t max_hits) {
  const std::size_t n = answers.closest.size();
  if (answers.any.size() != n || answers.counts.size() != n || answers.lists.size() != n)
    return "answers are missing";
  std::size_t end = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t begin = end;
    end += answers.lists[i].count;
    if (end > answers.listed.size()) return "hits are missing";
    const char* what =
        contradiction_of(answers.closest[i], answers.any[i], answers.counts[i], answers.lists[i],
                         std::span(answers.listed).subspan(begin, end - begin), max_hits);
    if (what == nullptr) continue;
    return fmt::format("ray {}: {}: closest t {} node {} primitive {}, any {}, count {}, {} listed",
                       i, what, answers.closest[i].t, answers.closest[i].node,
                       answers.closest[i].primitive, static_cast<int>(answers.any[i].state),
                       answers.counts[i].count, answers.lists[i].count);
  }
  return end == answers.listed.size() ? "" : "hits are left over";
}

Agreement compare_list(std::span<const Hit> hits, const RayTally& tally, const Reference& all) {
  if (all.invalid || tally.state == HitState::kInvalid) {
    const bool marked = all.invalid && tally.state == HitState::kInvalid && hits.empty();
    return marked ? Agreement::kEqual : Agreement::kMismatch;
  }
  Agreement agreement = Agreement::kEqual;
  for (const Hit& hit : hits) {
    const Candidate* c = find(hit, all);
    if (c == nullptr || std::abs(hit.t - c->t) > c->t_tolerance) return Agreement::kMismatch;
    if (!c->accepted && !c->borderline) return Agreement::kMismatch;
    if (!c->accepted) agreement = Agreement::kEdge;
  }
  for (const Candidate& c : all.candidates) {
    if (!c.accepted || holds(hits, c)) continue;
    if (tally.cut_off && !hits.empty() && c.t + c.t_tolerance >= hits.back().t) continue;
    if (!c.borderline) return Agreement::kMismatch;
    agreement = Agreement::kEdge;
  }
  return agreement;
}

Agreement compare_count(const RayTally& tally, const Reference& all) {
  if (all.invalid)
    return tally.count == scenegraph::kInvalidCount ? Agreement::kEqual : Agreement::kMismatch;
  std::uint64_t accepted = 0, firm = 0, possible = 0;
  for (const Candidate& c : all.candidates) {
    accepted += c.accepted;
    firm += c.accepted && !c.borderline;
    possible += c.accepted || c.borderline;
  }
  if (tally.count == accepted) return Agreement::kEqual;
  return tally.count >= firm && tally.count <= possible ? Agreement::kEdge : Agreement::kMismatch;
}

std::string KindComparison::report() const {
  std::string text =
      fmt::format("{} rays, {} hits, {} edges, {} mismatches", rays, hits, edges, mismatches);
  for (const std::string& example : examples) text += "\n" + example;
  return text;
}

KindComparison compare_kinds(std::span<const accel::geometry::Ray> rays, const KindAnswers& answers,
                             const BruteForce& oracle, const Filter& filter) {
  std::vector<std::size_t> begin(rays.size() + 1);
  for (std::size_t i = 0; i < rays.size(); ++i) begin[i + 1] = begin[i] + answers.lists[i].count;
  std::vector<std::array<Agreement, 4>> agreements(rays.size());
  tbb::parallel_for(std::size_t{0}, rays.size(), [&](std::size_t i) {
    const Reference all = oracle.trace_all(rays[i], filter);
    const auto listed = std::span(answers.listed).subspan(begin[i], begin[i + 1] - begin[i]);
    agreements[i] = {compare(answers.closest[i], nearest_part(all)),
                     compare_any(answers.any[i], all), compare_count(answers.counts[i], all),
                     compare_list(listed, answers.lists[i], all)};
  });
  KindComparison result;
  result.rays = rays.size();
  result.hits = answers.listed.size();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (std::size_t kind = 0; kind < 4; ++kind) {
      const Agreement agreement = agreements[i][kind];
      result.edges += agreement == Agreement::kEdge;
      result.mismatches += agreement == Agreement::kMismatch;
      if (agreement != Agreement::kMismatch || result.examples.size() >= kMaxExamples) continue;
      static constexpr std::array kNames{"closest", "any", "count", "all"};
      const accel::geometry::Ray& r = rays[i];
      result.examples.push_back(fmt::format(
          "{} of ray {}: o=({}, {}, {}) d=({}, {}, {}) t in [{}, {}] mask {:x}: count {}, listed "
          "{}",
          kNames[kind], i, r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y,
          r.direction.z, r.tmin, r.tmax, r.mask, answers.counts[i].count, answers.lists[i].count));
    }
  }
  return result;
}

}  // namespace sightline::tests

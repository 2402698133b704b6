// Text and JSON of the same numbers.
#include "client/cli/verbs/cast_report.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "client/cli/reporting.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/origin_precision.h"

namespace sightline::client::cli::verbs {
namespace {

double rays_per_second(const CastOutcome& outcome) {
  return outcome.seconds > 0 ? static_cast<double>(outcome.cast.rays) / outcome.seconds : 0;
}

std::string_view rows_of(const CastOutcome& outcome) {
  return files::layout_of(outcome.asked).rows;
}

Json json_of_faults(const CastOutcome& outcome) {
  const RayWatch& watch = outcome.watch;
  Json reasons = Json::object();
  for (std::size_t k = 1; k < kRayFaults; ++k) {
    if (watch.faults[k] > 0)
      reasons[std::string(info_of(RayFault(k), outcome.asked).key)] = watch.faults[k];
  }
  return reasons;
}

void warn_of_faults(const CastOutcome& outcome) {
  if (outcome.cast.invalid == 0) return;
  std::vector<std::string> reasons;
  for (std::size_t k = 1; k < kRayFaults; ++k) {
    if (outcome.watch.faults[k] == 0) continue;
    reasons.push_back(fmt::format("{} with {}", format_count(outcome.watch.faults[k]),
                                  info_of(RayFault(k), outcome.asked).text));
  }
  const bool has_rays = outcome.asked == files::RowKind::kRays;
  print_warning(fmt::format(
      "{} of {} {}: {}", format_count(outcome.cast.invalid), format_count(outcome.cast.rays),
      has_rays ? "rays cannot be cast" : "points are invalid", fmt::join(reasons, ", ")));
}

void warn_of_cuts(const CastOutcome& outcome) {
  if (outcome.cast.rays_cut_off == 0) return;
  print_warning(fmt::format("{} {} have more {} than were kept; --max-hits keeps more",
                            format_count(outcome.cast.rays_cut_off), rows_of(outcome),
                            outcome.asked == files::RowKind::kRays ? "hits" : "faces"));
}

void warn_of_origin_precision(const SceneInfo& scene, const CastOutcome& outcome) {
  if (outcome.float_reach == 0 || !scene.bounds) return;
  const std::string warning =
      origin_precision_warning(outcome.float_reach, *scene.bounds, outcome.asked);
  if (!warning.empty()) print_warning(warning);
}

}  // namespace

void warn_of_unanswered(const CastReport& cast, files::RowKind asked) {
  if (cast.unanswered == 0) return;
  print_warning(
      fmt::format("{} of {} {} have no answer: there was no time, or a server is lost; what was "
                  "built for them stays: {} again to go on from there",
                  format_count(cast.unanswered), format_count(cast.rays),
                  files::layout_of(asked).rows, asked == files::RowKind::kRays ? "cast" : "ask"));
}

Json json_of_cast(const CastOutcome& outcome, QueryKind kind, const SceneStats& stats) {
  const CastReport& cast = outcome.cast;
  const std::string rows(rows_of(outcome));
  Json json{{rows, cast.rays},
            {"hits", cast.hits},
            {"invalid", cast.invalid},
            {"unanswered", cast.unanswered},
            {"invalid_reasons", json_of_faults(outcome)},
            {"revision", cast.revision},
            {"token", cast.token},
            {"seconds", outcome.seconds},
            {rows + "_per_s", rays_per_second(outcome)},
            {"cells_expanded", cast.cells_expanded},
            {"trees_built", stats.trees_built},
            {"triangles_built", stats.triangles_built},
            {"triangles_total", stats.triangles_total},
            {"build_ms", static_cast<double>(cast.build_us) / 1000},
            {"trace_ms", static_cast<double>(cast.trace_us) / 1000},
            {"traversal_steps", cast.traversal_steps},
            {"triangle_tests", cast.triangle_tests},
            {"instances_entered", cast.instances_entered}};
  if (kind == QueryKind::kCount || kind == QueryKind::kAll) json["hits_found"] = cast.hits_found;
  if (!outcome.looks_for_faces) json["hits"] = nullptr;
  if (outcome.applied) json["nodes"] = outcome.applied->nodes;
  if (outcome.inside) json["inside"] = *outcome.inside;
  if (kind == QueryKind::kAll) json[rows + "_cut_off"] = cast.rays_cut_off;
  return json;
}

void print_cast_summary(std::FILE* to, const CastOutcome& outcome,
                        const std::optional<SceneStats>& stats) {
  const CastReport& cast = outcome.cast;
  const bool has_rays = outcome.asked == files::RowKind::kRays;
  const std::string_view rows = rows_of(outcome);
  const std::string found =
      !outcome.looks_for_faces
          ? ""
          : fmt::format(", {} {}", format_count(cast.hits), has_rays ? "hits" : "with a face");
  const std::string inside =
      outcome.inside ? fmt::format(", {} inside", format_count(*outcome.inside)) : "";
  fmt::print(to, "{} {}{}{}, {} invalid at revision {} in {:.3f} s ({:.3g} {}/s)\n",
             format_count(cast.rays), rows, found, inside, format_count(cast.invalid),
             cast.revision, outcome.seconds, rays_per_second(outcome), rows);
  fmt::print(to, "{} cells expanded in {:.1f} ms of thread time", format_count(cast.cells_expanded),
             static_cast<double>(cast.build_us) / 1000);
  if (stats)
    fmt::print(to, "; {} triangles built",
               format_share(stats->triangles_built, stats->triangles_total));
  fmt::print(to, "\n");
  if (outcome.applied && !outcome.applied->nodes.empty())
    fmt::print(to, "new nodes {}\n", fmt::join(outcome.applied->nodes, " "));
  if (cast.hits_found > 0) {
    fmt::print(to, "{} {} found\n", format_count(cast.hits_found), has_rays ? "hits" : "faces");
  }
}

void print_cast_warnings(const CastOutcome& outcome, const SceneInfo& scene) {
  warn_of_faults(outcome);
  warn_of_cuts(outcome);
  warn_of_unanswered(outcome.cast, outcome.asked);
  warn_of_origin_precision(scene, outcome);
}

}  // namespace sightline::client::cli::verbs

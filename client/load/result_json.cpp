// One object per row, with the figures that scripts read.
#include "client/load/result_json.h"

#include <array>
#include <cmath>
#include <utility>

namespace sightline::client::load {
namespace {

Json seconds_or_null(const std::optional<Nanoseconds>& time, Nanoseconds begin) {
  return time ? Json(seconds_of(*time - begin)) : Json(nullptr);
}

void add_latencies(Json& json, const std::string& prefix, const Histogram& latency) {
  constexpr std::array<std::pair<const char*, double>, 4> kQuantiles{
      {{"p50_ms", 0.5}, {"p90_ms", 0.9}, {"p99_ms", 0.99}, {"p999_ms", 0.999}}};
  for (const auto& [name, quantile] : kQuantiles)
    json[prefix + name] = latency_ms(latency, quantile);
  json[prefix + "max_ms"] = static_cast<double>(latency.max()) * 1e-6;
}

Json growth_json(const Row& row) {
  Json samples = Json::array();
  for (const GrowthSample& sample : row.growth) {
    samples.push_back({{"seconds", seconds_of(sample.time)},
                       {"triangles_built", sample.triangles_built},
                       {"bytes_trees", sample.bytes_trees}});
  }
  return samples;
}

Json row_json(const Row& row, const LoadResult& result) {
  const Record& record = row.run.record;
  Json json{{"build", name_of(row.build)},
            {"coverage", row.coverage},
            {"cold", row.cold},
            {"runs", row.runs},
            {"complete", row.run.complete},
            {"stable", row.run.stable},
            {"seconds", duration_s(row)},
            {"requests", record.latency.count()},
            {"rays", record.rays},
            {"hits", record.hits},
            {"rays_per_s", rays_per_s(row)}};
  add_latencies(json, "", record.latency);
  json["first_hit_s"] = seconds_or_null(record.first_hit, record.begin);
  json["last_hit_s"] = seconds_or_null(record.last_hit, record.begin);
  json["failed"] = record.failed;
  json["refused"] = record.refused;
  if (!row.growth.empty()) {
    json["triangles_built"] = row.growth.back().triangles_built;
    json["triangles_total"] = result.triangles_total;
    json["bytes_trees"] = row.growth.back().bytes_trees;
  }
  const TimeShares shares = time_shares(record, result.server.threads, is_full(row, result.server));
  json["queue_share"] = shares.queue;
  json["build_share"] = shares.build;
  json["trace_share"] = shares.trace;
  json["other_share"] = shares.other;
  json["client_cpu_share"] = row.use.own_share();
  if (record.update_latency.count() + record.updates_failed > 0) {
    json["updates"] = record.update_latency.count();
    json["updates_failed"] = record.updates_failed;
    add_latencies(json, "update_", record.update_latency);
  }
  json["growth"] = growth_json(row);
  return json;
}

}  // namespace

const char* name_of(QueryKind kind) {
  switch (kind) {
    case QueryKind::kClosest:
      return "closest";
    case QueryKind::kAny:
      return "any";
    case QueryKind::kCount:
      return "count";
    case QueryKind::kAll:
      return "all";
  }
  return "";
}

bool is_full(const Row& row, const ServerInfo& server) {
  return row.build == BuildMode::kFull ||
         (row.build == BuildMode::kServerPolicy && server.policy == "full");
}

const Row* find_row(const std::vector<Row>& rows, BuildMode build, double coverage) {
  for (const Row& row : rows) {
    if (row.build == build && row.coverage == coverage) return &row;
  }
  return nullptr;
}

Crossovers find_crossovers(const std::vector<Row>& rows) {
  Crossovers found;
  found.coverage = crossover(duration_by_coverage(rows, BuildMode::kLazy),
                             duration_by_coverage(rows, BuildMode::kFull), kSameTime);
  for (const Row& lazy : rows) {
    if (lazy.build != BuildMode::kLazy || !lazy.cold) continue;
    const Row* const full = find_row(rows, BuildMode::kFull, lazy.coverage);
    if (full == nullptr) continue;
    found.rays.push_back(
        {lazy.coverage, crossover(progress_of(lazy), progress_of(*full), kSameTime)});
  }
  return found;
}

Json to_json(const LoadOptions& options, const LoadContext& context, const LoadResult& result) {
  Json rows = Json::array();
  for (const Row& row : result.rows) rows.push_back(row_json(row, result));
  const auto or_null = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  const Crossovers crossovers = find_crossovers(result.rows);
  Json by_rays = Json::array();
  for (const auto& [coverage, rays] : crossovers.rays)
    by_rays.push_back({{"coverage", coverage}, {"rays", or_null(rays)}});
  return {{"scene", options.scene},
          {"revision", result.scene.revision},
          {"kind", name_of(options.kind)},
          {"rays", context.rays},
          {"batch", options.batch},
          {"clients", options.rate ? Json(nullptr) : Json(options.clients)},
          {"rate", or_null(options.rate)},
          {"updates", options.updates},
          {"rows", std::move(rows)},
          {"crossovers", {{"coverage", or_null(crossovers.coverage)}, {"rays", by_rays}}},
          {"warnings", result.warnings},
          {"server",
           {{"version", result.server.version},
            {"policy", result.server.policy},
            {"threads", result.server.threads},
            {"simd_target", result.server.simd_target}}},
          {"machine",
           {{"processor", context.machine.processor},
            {"processors", context.machine.processors},
            {"memory_bytes", context.machine.memory_bytes},
            {"system", context.machine.system}}},
          {"client_version", context.client_version},
          {"time", context.machine.time},
          {"command", context.command}};
}

}  // namespace sightline::client::load

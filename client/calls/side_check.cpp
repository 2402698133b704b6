// The limits are those of the server.
#include "client/calls/side_check.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace sightline::client::calls {
namespace {

Error refused(std::string message, const char* reason) {
  return {Code::kInvalidArgument, std::move(message), reason};
}

}  // namespace

Status check_sides(const CastOptions& options, HitFields fields) {
  const bool is_asked = fields.has_sides();
  if (is_asked && options.kind != QueryKind::kClosest)
    return refused("signed_distance, inside and votes go with kClosest alone", "FIELD_NOT_OF_KIND");
  if (!is_asked && has_sides(options)) {
    return refused(
        "side_rule and side_rays are for signed_distance, inside and votes: none of them is asked",
        "SIDE_NOT_ASKED");
  }
  const std::uint32_t rays = options.side_rays;
  if (rays > kMaxSideRays || (rays > 0 && rays % 2 == 0)) {
    return refused(
        fmt::format("side_rays is {}, but must be odd and at most {}", rays, kMaxSideRays),
        "SIDE_RAYS");
  }
  if (options.side_rule != SideRule::kNormal) return {};
  if (rays > 1)
    return refused(fmt::format("side_rays is {}, but kNormal casts no rays", rays), "SIDE_RAYS");
  if (fields.votes)
    return refused("votes are of rays, and kNormal casts none", "FIELD_NOT_OF_RULE");
  return {};
}

Status check_no_sides(const CastOptions& options, HitFields fields) {
  if (fields.has_sides())
    return refused("signed_distance, inside and votes are of points", "FIELD_NOT_OF_KIND");
  if (has_sides(options)) return refused("side_rule and side_rays are of points", "SIDE_NOT_ASKED");
  return {};
}

bool has_sides(const CastOptions& options) {
  return options.side_rule.has_value() || options.side_rays > 0;
}

CastOptions without_sides(CastOptions options) {
  options.side_rule.reset();
  options.side_rays = 0;
  return options;
}

}  // namespace sightline::client::calls

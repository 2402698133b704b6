// What a batch of rays may hold while it is served.
#include "server/queries/cast_admission.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "scenegraph/query/shard_sides.h"
#include "server/queries/derived_columns.h"
#include "server/queries/hit_codec.h"
#include "server/queries/side_columns.h"
#include "server/shards/peers.h"
#include "server/shards/sharded_cast.h"

namespace sightline::server::queries {
namespace {

/// Bytes of a reply with every field that neither DerivedColumns nor SideColumns writes.
constexpr std::size_t kReplyBytesPerRay = 48;
/// Bytes of a decoded ray and its hit: enough for rays that are made for a slice, too.
constexpr std::size_t kSliceBytesPerRay =
    sizeof(accel::geometry::Ray) + sizeof(accel::geometry::Hit);

bool lists(const CastQuery& query) { return query.kind == scenegraph::QueryKind::kAll; }

}  // namespace

Status CastAdmission::admit(std::size_t request_bytes, const CastQuery& query, std::size_t rays,
                            bool sharded) {
  auto quota = services_.quotas.begin_work(caller_, rays, request_bytes);
  if (!quota) return quota.error();
  if (lists(query) && replies_ == Replies::kOne && rays * query.max_hits > kMaxHitsPerReply) {
    return Error{Code::kInvalidArgument,
                 fmt::format("{} rays with up to {} hits each are {} hits, the limit of one reply "
                             "is {}; send fewer, lower max_hits or use StreamCastRays",
                             rays, query.max_hits, rays * query.max_hits, kMaxHitsPerReply),
                 "TOO_MANY_HITS"};
  }
  if (query.crossings && rays * query.sides->rays > scenegraph::query::kMaxCrossings) {
    return Error{
        Code::kInvalidArgument,
        fmt::format("{} points with the crossings of {} rays each are {}, the limit is {}", rays,
                    query.sides->rays, rays * query.sides->rays, scenegraph::query::kMaxCrossings),
        "TOO_MANY_CROSSINGS"};
  }
  const std::size_t bytes = bytes_of(request_bytes, query, rays, sharded);
  if (lists(query)) {
    auto all_hits = services_.all_hits_admission.admit(caller_, rays, bytes);
    if (!all_hits) return all_hits.error();
    all_hits_ticket_ = std::move(*all_hits);
  }
  auto ticket = services_.admission.admit(caller_, rays, bytes);
  if (!ticket && rays <= kSmallCast) {
    if (auto reserve = services_.small_admission.admit(caller_, rays, bytes))
      ticket = std::move(reserve);
  }
  if (!ticket) return ticket.error();
  ticket_ = std::move(*ticket);
  quota_ = std::move(*quota);
  return {};
}

std::size_t CastAdmission::bytes_of(std::size_t request_bytes, const CastQuery& query,
                                    std::size_t rays, bool sharded) const {
  const std::size_t decoded = lists(query) ? rays : std::min(rays, kRaysPerSlice);
  // The rows of a segment's columns are made slice by slice.
  const std::size_t rows = query.in_segment ? decoded : rays;
  const std::size_t listed = lists(query) ? std::min(rays * query.max_hits, kMaxHitsPerReply) : 0;
  std::size_t bytes =
      request_bytes + decoded * kSliceBytesPerRay + rows * kReplyBytesPerRay +
      derived_bytes(query, lists(query) ? listed : rows, lists(query) ? listed : rays);
  if (query.sides) bytes += side_bytes(query, rows, decoded);
  if (lists(query))
    bytes += hit_pager_bytes(rays, query.max_hits, services_.compute.threads(), first_list());
  if (sharded) {
    bytes += rays * shards::kShardedBytesPerRay +
             listed * shards::kShardedBytesPerHit * services_.shard_peers.size();
    if (query.sides)
      bytes += shards::sharded_side_bytes(rays, *query.sides, services_.shard_peers.size());
  }
  return bytes;
}

void CastAdmission::release() {
  quota_ = {};
  ticket_ = {};
  all_hits_ticket_ = {};
  more_ticket_ = {};
  more_all_hits_ticket_ = {};
  lists_more_ = false;
}

bool CastAdmission::list_more(const CastQuery& query, std::size_t rays) {
  if (lists_more_) return false;
  const auto bytes = [&](const ListSize& size) {
    return hit_pager_bytes(rays, query.max_hits, services_.compute.threads(), size);
  };
  const std::size_t more = bytes(kFullList) - bytes(kFirstList);
  auto of_all_hits = services_.all_hits_admission.admit(caller_, 0, more);
  if (!of_all_hits) return false;
  auto of_all = services_.admission.admit(caller_, 0, more);
  if (!of_all) return false;
  more_all_hits_ticket_ = std::move(*of_all_hits);
  more_ticket_ = std::move(*of_all);
  lists_more_ = true;
  return true;
}

}  // namespace sightline::server::queries

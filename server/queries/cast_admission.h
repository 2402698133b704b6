// What a batch of rays may hold while it is served.
#pragma once

#include <cstddef>
#include <cstdint>

#include "proto/result.h"
#include "server/exec/admission.h"
#include "server/exec/caller.h"
#include "server/exec/quotas.h"
#include "server/queries/cast_query.h"
#include "server/queries/hit_pager.h"
#include "server/scenes/services.h"

namespace sightline::server::queries {

/// Casts of up to this number of rays have their own workers and a reserve of admission.
inline constexpr std::size_t kSmallCast = 256;
/// Most rays of one slice of a batch. Lists of hits are sliced by HitPager.
inline constexpr std::size_t kRaysPerSlice = 4096;

/// How many messages may answer a batch.
enum class Replies : std::uint8_t { kOne, kMany };

/// Books what the batches of one call take, one after the other.
class CastAdmission {
 public:
  CastAdmission(const scenes::Services& services, const exec::Caller& caller, Replies replies)
      : services_(services), caller_(caller), replies_(replies) {}

  /// Books a batch of `rays`, whose request has `request_bytes`. `sharded`: peers answer it.
  /// Errors: as Quotas::begin_work and Admission::admit; kInvalidArgument if one reply cannot hold
  /// all hits, or there are more than kMaxCrossings.
  Status admit(std::size_t request_bytes, const CastQuery& query, std::size_t rays, bool sharded);
  /// Frees what the batch has booked.
  void release();

  /// The lists that a batch begins with. A single reply has all hits.
  const ListSize& first_list() const { return replies_ == Replies::kOne ? kFullList : kFirstList; }
  /// There are many hits: books what it takes to list more of them at a time. False: it is not
  /// granted, or was before.
  bool list_more(const CastQuery& query, std::size_t rays);

 private:
  std::size_t bytes_of(std::size_t request_bytes, const CastQuery& query, std::size_t rays,
                       bool sharded) const;

  const scenes::Services& services_;
  const exec::Caller& caller_;
  const Replies replies_;
  exec::Quotas::Use quota_;
  exec::Admission::Ticket ticket_, all_hits_ticket_;
  exec::Admission::Ticket more_ticket_, more_all_hits_ticket_;  // what list_more() has booked
  bool lists_more_ = false;
};

}  // namespace sightline::server::queries

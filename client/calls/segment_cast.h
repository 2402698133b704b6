// Casts through a segment, where the client has one. Internal to the library.
#pragma once

#include <optional>
#include <string>

#include "client/calls/retries.h"
#include "client/cast_options.h"
#include "client/result.h"

namespace sightline::client::calls {

struct Connection;

/// A cast of fewer rows goes by messages: a call with a segment costs about as much as sending
/// them.
inline constexpr std::size_t kLeastSegmentRows = 1024;

/// Casts rows of any kind but generators, which were checked, in one message if they fit one, else
/// over a stream. Nothing: the cast goes by messages, which nothing has been sent of that counts.
/// Errors: those of a cast; kFailedPrecondition (MEMORY_ABANDONED).
template <class Columns>
std::optional<Result<CastReport>> cast_in_segment(const Connection& connection,
                                                  const std::string& scene, const Columns& rows,
                                                  const HitColumns& hits,
                                                  const CastOptions& options,
                                                  Retries::Deadline deadline);

/// Casts rows of any kind over a stream. Otherwise as cast_in_segment().
template <class Rows>
std::optional<Result<CastReport>> stream_in_segment(const Connection& connection,
                                                    const std::string& scene, const Rows& rows,
                                                    const HitColumns& hits,
                                                    const CastOptions& options,
                                                    Retries::Deadline deadline);

}  // namespace sightline::client::calls

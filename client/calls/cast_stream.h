// A cast over a stream of messages, which goes on where it was after a broken connection. Internal
// to the library.
#pragma once

#include <string>

#include "client/calls/message_source.h"
#include "client/calls/retries.h"
#include "client/cast_options.h"
#include "client/result.h"

namespace sightline::client::calls {

struct Connection;
template <class Request>
class SegmentMessages;

/// Casts what `source` gives, and hands the answers to `sink` in order, each once. One thread
/// writes and one reads. If the connection breaks, what was not answered is sent again, over a new
/// one, to any replica, and answered at the revision of the first answer. Errors: kAborted, the
/// scene was deleted and made anew meanwhile; kOutOfRange, its revision is not kept any more.
/// Request is v1::CastRaysRequest or v1::QueryPointsRequest.
template <class Request>
Result<CastReport> cast_messages(const Connection& connection, const std::string& scene,
                                 const MessageSource<Request>& source, HitFields fields,
                                 const HitSink& sink, const CastOptions& options);

/// As cast_messages(), through a segment. What the server does not answer there, as it has lost the
/// segment or the connection broke, is sent in messages without one, unless the server might still
/// write to the caller's memory. Not for kAll.
template <class Request>
Result<CastReport> cast_messages(const Connection& connection, const std::string& scene,
                                 SegmentMessages<Request>& messages, HitFields fields,
                                 const HitSink& sink, const CastOptions& options,
                                 Retries::Deadline deadline);

}  // namespace sightline::client::calls

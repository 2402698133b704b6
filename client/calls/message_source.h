// The rows of one message after the other: rays or points. Internal to the library.
#pragma once

#include <cstddef>
#include <functional>

#include "client/cast_options.h"
#include "client/points.h"
#include "client/ray_generator.h"
#include "client/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::calls {

/// Sets the rows of the next message, and returns their number; 0: there are no more. Request is a
/// request that has such rows, or what makes them.
template <class Request>
using MessageSource = std::function<Result<std::size_t>(Request& request)>;

/// The rows of a source. Both must outlive the messages.
template <class Request, class Columns>
MessageSource<Request> messages_of(const RowSource<Columns>& source, typename Columns::Shape shape);

/// Parts of a generator. Errors: as of make_rays() and make_points().
template <class Request>
Result<MessageSource<Request>> messages_of(const RayGenerator& generator);
template <class Request>
Result<MessageSource<Request>> messages_of(const PointGrid& grid);

}  // namespace sightline::client::calls

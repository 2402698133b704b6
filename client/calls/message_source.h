// The rays of one message after the other. Internal to the library.
#pragma once

#include <cstddef>
#include <functional>

#include "client/cast_options.h"
#include "client/ray_generator.h"
#include "client/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::calls {

/// Sets the rays of the next message, and returns their number; 0: there
/// are no more. Request is a request that has rays or a generator.
template <class Request>
using MessageSource = std::function<Result<std::size_t>(Request& request)>;

/// The rays of a source. Both must outlive the messages.
template <class Request, class Scalar>
MessageSource<Request> messages_of(const RaySource<Scalar>& source, RayShape shape);

/// Parts of a generator. Errors: as of make_rays().
template <class Request>
Result<MessageSource<Request>> messages_of(const RayGenerator& generator);

}  // namespace sightline::client::calls

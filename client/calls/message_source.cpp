// The rays of one message after the other.
#include "client/calls/message_source.h"

#include <algorithm>
#include <cstdint>

#include "client/wire/cast_codec.h"
#include "client/wire/generator_codec.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

template <class Request, class Scalar>
MessageSource<Request> messages_of(const RaySource<Scalar>& source, RayShape shape) {
  return [&source, shape](Request& request) -> Result<std::size_t> {
    v1::Rays& rays = *request.mutable_rays();
    auto count = source(wire::resize_columns<Scalar>(kRaysPerMessage, shape, rays));
    if (count) wire::trim<Scalar>(*count, shape, rays);
    return count;
  };
}

template <class Request>
Result<MessageSource<Request>> messages_of(const RayGenerator& generator) {
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  v1::RayGenerator message;
  wire::encode(generator, message);
  const std::uint64_t end = generator.first + proto::rays::count_of(generator);
  return MessageSource<Request>(
      [message, end, next = generator.first](Request& request) mutable -> Result<std::size_t> {
        if (!request.has_generator()) *request.mutable_generator() = message;
        const std::uint64_t count = std::min<std::uint64_t>(end - next, kGeneratedRaysPerMessage);
        request.mutable_generator()->set_first(next);
        request.mutable_generator()->set_count(count);
        next += count;
        return count;
      });
}

template MessageSource<v1::CastRaysRequest> messages_of(const RaySource<float>&, RayShape);
template MessageSource<v1::CastRaysRequest> messages_of(const RaySource<double>&, RayShape);
template MessageSource<v1::PrefetchRequest> messages_of(const RaySource<float>&, RayShape);
template MessageSource<v1::PrefetchRequest> messages_of(const RaySource<double>&, RayShape);
template Result<MessageSource<v1::CastRaysRequest>> messages_of(const RayGenerator&);
template Result<MessageSource<v1::PrefetchRequest>> messages_of(const RayGenerator&);

}  // namespace sightline::client::calls

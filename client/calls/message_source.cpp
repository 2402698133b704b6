// The rows of one message after the other.
#include "client/calls/message_source.h"

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "client/wire/cast_codec.h"
#include "client/wire/generator_codec.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

namespace {

template <class Shape, class Request>
auto& rows_of(Request& request) {
  if constexpr (std::is_same_v<Shape, PointShape>) {
    return *request.mutable_points();
  } else {
    return *request.mutable_rays();
  }
}

/// The `count` rows from `first` on that the message describes. `mutable_message` and `has_message`
/// are the request's own.
template <class Request, class Message>
MessageSource<Request> parts_of(Message message, std::uint64_t first, std::uint64_t count,
                                Message* (Request::*mutable_message)(),
                                bool (Request::*has_message)() const) {
  return [message = std::move(message), mutable_message, has_message, end = first + count,
          next = first](Request& request) mutable -> Result<std::size_t> {
    const bool is_described = (request.*has_message)();
    Message& part = *(request.*mutable_message)();
    if (!is_described) part = message;
    const std::uint64_t rows = std::min<std::uint64_t>(end - next, kGeneratedRaysPerMessage);
    part.set_first(next);
    part.set_count(rows);
    next += rows;
    return rows;
  };
}

}  // namespace

template <class Request, class Columns>
MessageSource<Request> messages_of(const RowSource<Columns>& source,
                                   typename Columns::Shape shape) {
  using Scalar = typename Columns::Value;
  return [&source, shape](Request& request) -> Result<std::size_t> {
    auto& rows = rows_of<typename Columns::Shape>(request);
    auto count = source(wire::resize_columns<Scalar>(kRaysPerMessage, shape, rows));
    if (count) wire::trim<Scalar>(*count, shape, rows);
    return count;
  };
}

template <class Request>
Result<MessageSource<Request>> messages_of(const RayGenerator& generator) {
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  v1::RayGenerator message;
  wire::encode(generator, message);
  return parts_of<Request>(std::move(message), generator.first, proto::rays::count_of(generator),
                           &Request::mutable_generator, &Request::has_generator);
}

template <class Request>
Result<MessageSource<Request>> messages_of(const PointGrid& grid) {
  if (const auto problem = proto::rays::check(grid))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  v1::PointGrid message;
  wire::encode(grid, message);
  return parts_of<Request>(std::move(message), grid.first, proto::rays::count_of(grid),
                           &Request::mutable_grid, &Request::has_grid);
}

template MessageSource<v1::CastRaysRequest> messages_of(const RaySource<float>&, RayShape);
template MessageSource<v1::CastRaysRequest> messages_of(const RaySource<double>&, RayShape);
template MessageSource<v1::PrefetchRequest> messages_of(const RaySource<float>&, RayShape);
template MessageSource<v1::PrefetchRequest> messages_of(const RaySource<double>&, RayShape);
template MessageSource<v1::PrefetchRequest> messages_of(const PointSource<float>&, PointShape);
template MessageSource<v1::PrefetchRequest> messages_of(const PointSource<double>&, PointShape);
template MessageSource<v1::QueryPointsRequest> messages_of(const PointSource<float>&, PointShape);
template MessageSource<v1::QueryPointsRequest> messages_of(const PointSource<double>&, PointShape);
template Result<MessageSource<v1::CastRaysRequest>> messages_of(const RayGenerator&);
template Result<MessageSource<v1::PrefetchRequest>> messages_of(const RayGenerator&);
template Result<MessageSource<v1::PrefetchRequest>> messages_of(const PointGrid&);
template Result<MessageSource<v1::QueryPointsRequest>> messages_of(const PointGrid&);

}  // namespace sightline::client::calls

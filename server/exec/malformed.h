// Requests whose bytes are no message of their type: gRPC says UNIMPLEMENTED for one that is alone,
// and takes one on a stream for the stream's end. Strings that are not UTF-8 are such bytes, too.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/support/server_interceptor.h>

#include <cstddef>
#include <memory>

#include "proto/result.h"

namespace sightline::server::exec {

/// The error of such a request: kInvalidArgument, reason MALFORMED_MESSAGE.
Error malformed_message();

/// An interceptor for grpc::ServerBuilder that makes calls with one request end with
/// malformed_message(). Makes protobuf's parser silent in this process.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> refuse_malformed();

/// A call that waits for its peer keeps the memory of messages of this many bytes on the wire.
inline constexpr std::size_t kIdleMessage = std::size_t{8} << 10;

/// Frees the memory of a larger message: cleared, it would keep it. Call it before a call waits for
/// its peer.
void free_if_large(google::protobuf::Message& message);

/// Call this before each read of a stream, for the message that it fills. Frees a large one.
void before_read(google::protobuf::Message& message);

/// How a read ended that got no message: OK if the client closed its side or is gone, or
/// malformed_message(). Call this once after a failed read.
Status end_of_reads(const google::protobuf::Message& message);

}  // namespace sightline::server::exec

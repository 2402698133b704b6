// A fuzzer's input as calls of a client, one after the other.
#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sightline::tests {

/// A call of methods()[method % methods().size()]. The messages need not be of its type.
struct FuzzCall {
  std::uint8_t method = 0;
  std::vector<std::string> messages;
};
using Session = std::vector<FuzzCall>;

/// Takes any bytes. Lengths beyond the end are cut.
Session decode_session(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> encode_session(const Session& session);

/// Requests that name this segment mean the one that is open while sessions run: its real name
/// cannot be guessed. It begins with kSegmentRows origins in double, and as many directions behind
/// them.
inline const std::string kFuzzSegment = "segment";
inline constexpr std::uint64_t kFuzzSegmentBytes = std::uint64_t{64} << 10;
inline constexpr std::uint64_t kSegmentRows = 512;

/// All methods of the service, always in the same order.
const std::vector<const google::protobuf::MethodDescriptor*>& methods();
const google::protobuf::MethodDescriptor& method_of(const FuzzCall& call);

/// The message as the method's request; null if it is not one.
std::unique_ptr<google::protobuf::Message> parse(const FuzzCall& call, const std::string& message);

/// Sessions that use every method as it is meant.
std::vector<Session> example_sessions();

}  // namespace sightline::tests

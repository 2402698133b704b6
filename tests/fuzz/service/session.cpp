// A fuzzer's input as calls of a client, one after the other.
#include "tests/fuzz/service/session.h"

#include <algorithm>

#include "sightline/v1/blob.pb.h"
#include "sightline/v1/query.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {
namespace {

namespace pb = google::protobuf;

constexpr std::size_t kMaxCalls = 32;

}  // namespace

Session decode_session(std::span<const std::uint8_t> bytes) {
  Bytes in(bytes);
  Session session;
  while (!in.empty() && session.size() < kMaxCalls) {
    FuzzCall call{.method = in.take<std::uint8_t>(), .messages = {}};
    const auto count = in.take<std::uint8_t>();
    for (int i = 0; i < count && !in.empty(); ++i) {
      const std::size_t length = in.take<std::uint32_t>();
      const auto message = in.rest().first(std::min(length, in.rest().size()));
      call.messages.emplace_back(message.begin(), message.end());
      in = Bytes(in.rest().subspan(message.size()));
    }
    session.push_back(std::move(call));
  }
  return session;
}

std::vector<std::uint8_t> encode_session(const Session& session) {
  std::vector<std::uint8_t> out;
  for (const FuzzCall& call : session) {
    const std::size_t count = std::min<std::size_t>(call.messages.size(), 255);
    out.push_back(call.method);
    out.push_back(static_cast<std::uint8_t>(count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& message = call.messages[i];
      for (int shift = 0; shift < 32; shift += 8)
        out.push_back(static_cast<std::uint8_t>(message.size() >> shift));
      out.insert(out.end(), message.begin(), message.end());
    }
  }
  return out;
}

const std::vector<const pb::MethodDescriptor*>& methods() {
  static const auto* const all = [] {
    auto* found = new std::vector<const pb::MethodDescriptor*>;
    for (const pb::FileDescriptor* file :
         {v1::CastRaysRequest::descriptor()->file(), v1::Update::descriptor()->file(),
          v1::UploadBlobRequest::descriptor()->file(),
          v1::GetServerInfoRequest::descriptor()->file()}) {
      for (int s = 0; s < file->service_count(); ++s) {
        for (int m = 0; m < file->service(s)->method_count(); ++m)
          found->push_back(file->service(s)->method(m));
      }
    }
    // These came later: kept sessions name the others by their numbers.
    std::stable_partition(found->begin(), found->end(), [](const pb::MethodDescriptor* method) {
      return method->name() != "QueryPoints" && method->name() != "StreamQueryPoints" &&
             method->name() != "OpenSegment";
    });
    return found;
  }();
  return *all;
}

const pb::MethodDescriptor& method_of(const FuzzCall& call) {
  return *methods()[call.method % methods().size()];
}

std::unique_ptr<pb::Message> parse(const FuzzCall& call, const std::string& message) {
  const pb::Descriptor* type = method_of(call).input_type();
  std::unique_ptr<pb::Message> made(
      pb::MessageFactory::generated_factory()->GetPrototype(type)->New());
  return made->ParseFromString(message) ? std::move(made) : nullptr;
}

}  // namespace sightline::tests

// Checks what the server promises, whatever a client sends.
#include "tests/fuzz/service/check_session.h"

#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "client/calls/segment_handover.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/server.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.pb.h"
#include "tests/fuzz/service/raw_rpc.h"

namespace sightline::tests {
namespace {

using Code = grpc::StatusCode;

/// A call that takes longer hangs.
constexpr std::chrono::seconds kLimit{60};
/// Watches and segments have no end of their own.
constexpr std::chrono::milliseconds kWatch{20};

const std::string kKept = "projects/kept/scenes/kept";

bool has_no_end(const FuzzCall& call) {
  const std::string& name = method_of(call).name();
  return name == "WatchScene" || name == "OpenSegment";
}

std::string path_of(const FuzzCall& call) {
  const auto& method = method_of(call);
  return "/" + method.service()->full_name() + "/" + method.name();
}

[[noreturn]] void die(const std::string& why) {
  std::fprintf(stderr, "service: %s\n", why.c_str());
  std::abort();
}

/// A segment, which is open and mapped as long as this object.
class FuzzSegment {
 public:
  explicit FuzzSegment(const std::shared_ptr<grpc::Channel>& channel)
      : rays_(v1::RayQueryService::NewStub(channel)) {
    v1::OpenSegmentRequest request;
    request.set_bytes(kFuzzSegmentBytes);
    reader_ = rays_->OpenSegment(&context_, request);
    if (!reader_->Read(&opened_)) die("no segment is opened");
    auto received = client::calls::receive_segment(opened_.socket(), opened_.key(), opened_.bytes(),
                                                   std::chrono::system_clock::now() + kLimit);
    if (!received) die(received.error().message);
    received_.emplace(*std::move(received));
  }
  ~FuzzSegment() {
    context_.TryCancel();
    static_cast<void>(reader_->Finish());
  }
  FuzzSegment(const FuzzSegment&) = delete;
  FuzzSegment& operator=(const FuzzSegment&) = delete;

  const std::string& name() const { return opened_.segment(); }

  /// The same rays for each session, and nothing of the answers to the last.
  void fill() const {
    constexpr std::array<double, 6> kRay{0.5, 0.25, 5, 0, 0, -1};
    std::array<double, kFuzzSegmentBytes / sizeof(double)> values{};
    for (std::size_t i = 0; i < 6 * kSegmentRows; ++i)
      values[i] = kRay[i % 3 + (i < 3 * kSegmentRows ? 0 : 3)];
    std::memcpy(received_->memory.data(), values.data(), sizeof values);
  }

 private:
  const std::unique_ptr<v1::RayQueryService::Stub> rays_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::OpenSegmentResponse>> reader_;
  v1::OpenSegmentResponse opened_;
  std::optional<client::calls::ReceivedSegment> received_;
};

/// A server with a scene that no session knows, and a segment that sessions may name.
class Target {
 public:
  Target() {
    spdlog::set_level(spdlog::level::off);
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.threads = 2;
    config.memory_budget = std::uint64_t{64} << 20;
    config.segments = server::segments::Offer::kLocal;
    auto started = server::Server::start(config);
    if (!started) die(started.error().message);
    server_ = std::move(*started);
    channel_ = grpc::CreateChannel(fmt::format("127.0.0.1:{}", server_->port()),
                                   grpc::InsecureChannelCredentials());
    if (!channel_->WaitForConnected(std::chrono::system_clock::now() + kLimit))
      die("no connection");
    segment_.emplace(channel_);
    segment_->fill();
    const Session example = example_sessions().front();
    for (FuzzCall call : example) {
      for (std::string& message : call.messages) message = for_kept_scene(call, message);
      const RawReply reply = run(call);
      if (!reply.status.ok()) die(path_of(call) + ": " + reply.status.error_message());
      if (method_of(call).name() == "CastRays") kept_.emplace_back(call, hits_of(reply));
    }
  }

  void begin_session() const { segment_->fill(); }

  RawReply run(const FuzzCall& call) const {
    std::vector<std::string> messages;
    for (const std::string& message : call.messages) messages.push_back(named(call, message));
    return raw_rpc(channel_, path_of(call), messages,
                   has_no_end(call) ? kWatch : std::chrono::milliseconds(kLimit));
  }

  /// Describes an answer about the kept scene that has changed.
  std::optional<std::string> check_kept_scene() const {
    for (const auto& [call, hits] : kept_) {
      const RawReply reply = run(call);
      if (!reply.status.ok()) return "another client's cast fails: " + reply.status.error_message();
      if (hits_of(reply) != hits) return "another client gets other hits";
    }
    return std::nullopt;
  }

 private:
  /// The message, with the name of the open segment where it means that.
  std::string named(const FuzzCall& call, const std::string& message) const {
    const auto typed = parse(call, message);
    if (!typed) return message;
    const auto name_in = [&](auto& request) {
      if (request.segment() != kFuzzSegment) return message;
      request.set_segment(segment_->name());
      return typed->SerializeAsString();
    };
    if (auto* rays = dynamic_cast<v1::CastRaysRequest*>(typed.get())) return name_in(*rays);
    if (auto* near = dynamic_cast<v1::QueryPointsRequest*>(typed.get())) return name_in(*near);
    if (auto* stream = dynamic_cast<v1::StreamCastRaysRequest*>(typed.get()))
      return name_in(*stream->mutable_request());
    if (auto* points = dynamic_cast<v1::StreamQueryPointsRequest*>(typed.get()))
      return name_in(*points->mutable_request());
    return message;
  }

  static std::string for_kept_scene(const FuzzCall& call, const std::string& message) {
    const auto typed = parse(call, message);
    if (!typed) die("an example is no " + method_of(call).input_type()->name());
    const auto* field = typed->GetDescriptor()->FindFieldByName("scene");
    if (auto* create = dynamic_cast<v1::CreateSceneRequest*>(typed.get())) {
      create->mutable_scene()->set_name(kKept);
    } else if (auto* stream = dynamic_cast<v1::StreamCastRaysRequest*>(typed.get())) {
      stream->mutable_request()->set_scene(kKept);
    } else if (auto* points = dynamic_cast<v1::StreamQueryPointsRequest*>(typed.get())) {
      points->mutable_request()->set_scene(kKept);
    } else if (field != nullptr) {
      typed->GetReflection()->SetString(typed.get(), field, kKept);
    }
    return typed->SerializeAsString();
  }

  static std::string hits_of(const RawReply& reply) {
    v1::CastRaysResponse answer;
    if (reply.messages.size() != 1 || !answer.ParseFromString(reply.messages[0])) return {};
    std::string all;
    for (const v1::HitColumn& column : answer.columns()) all += column.SerializeAsString();
    return all;
  }

  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::optional<FuzzSegment> segment_;
  std::vector<std::pair<FuzzCall, std::string>> kept_;
};

bool has_reason(const grpc::Status& status) {
  google::rpc::Status details;
  google::rpc::ErrorInfo info;
  return details.ParseFromString(status.error_details()) && details.details_size() > 0 &&
         details.details(0).UnpackTo(&info) && !info.reason().empty();
}

/// A unary call takes exactly one message of its type; gRPC itself refuses others.
bool is_well_formed(const FuzzCall& call) {
  if (!method_of(call).client_streaming() && call.messages.size() != 1) return false;
  for (const std::string& message : call.messages) {
    if (!parse(call, message)) return false;
  }
  return true;
}

std::optional<std::string> check_status(const FuzzCall& call, const grpc::Status& status) {
  if (status.ok()) return std::nullopt;
  if (has_no_end(call) && status.error_code() == Code::DEADLINE_EXCEEDED) return std::nullopt;
  if (!is_well_formed(call)) return std::nullopt;
  static const std::set<Code> kOwnFaults{Code::UNKNOWN, Code::INTERNAL, Code::UNIMPLEMENTED,
                                         Code::DEADLINE_EXCEEDED, Code::UNAVAILABLE};
  if (kOwnFaults.contains(status.error_code()) || !has_reason(status)) {
    return fmt::format("{} ends with code {}: {}", path_of(call),
                       static_cast<int>(status.error_code()), status.error_message());
  }
  return std::nullopt;
}

/// The names of the scenes that the call created.
std::set<std::string> created_by(const FuzzCall& call, const RawReply& reply) {
  std::set<std::string> names;
  v1::CreateSceneResponse answer;
  if (method_of(call).name() == "CreateScene" && reply.status.ok() && !reply.messages.empty() &&
      answer.ParseFromString(reply.messages[0]))
    names.insert(answer.scene().name());
  v1::PutSceneResponse put;
  if (method_of(call).name() == "PutScene" && reply.status.ok() && !reply.messages.empty() &&
      put.ParseFromString(reply.messages[0]))
    names.insert(put.scene().name());
  return names;
}

FuzzCall deletion_of(const std::string& scene) {
  const auto& all = methods();
  const auto found = std::find_if(
      all.begin(), all.end(), [](const auto* method) { return method->name() == "DeleteScene"; });
  FuzzCall call{.method = static_cast<std::uint8_t>(found - all.begin()), .messages = {}};
  v1::DeleteSceneRequest request;
  request.set_name(scene);
  call.messages = {request.SerializeAsString()};
  return call;
}

}  // namespace

std::optional<std::string> check_session(const Session& session) {
  static const Target target;  // ends before leaks are looked for
  std::optional<std::string> wrong;
  std::set<std::string> scenes;
  target.begin_session();
  for (const FuzzCall& call : session) {
    const RawReply reply = target.run(call);
    if (!wrong) wrong = check_status(call, reply.status);
    scenes.merge(created_by(call, reply));
  }
  if (!wrong) wrong = target.check_kept_scene();
  for (const std::string& scene : scenes) static_cast<void>(target.run(deletion_of(scene)));
  return wrong;
}

}  // namespace sightline::tests

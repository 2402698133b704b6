// Checks what the server promises, whatever a client sends.
#include "tests/fuzz/service/check_session.h"

#include <fmt/format.h>
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/server.h"
#include "sightline/v1/query.pb.h"
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

/// A server with a scene that no session knows.
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
    const Session example = example_sessions().front();
    for (FuzzCall call : example) {
      for (std::string& message : call.messages) message = for_kept_scene(call, message);
      const RawReply reply = run(call);
      if (!reply.status.ok()) die(path_of(call) + ": " + reply.status.error_message());
      if (method_of(call).name() == "CastRays") kept_.emplace_back(call, hits_of(reply));
    }
  }

  RawReply run(const FuzzCall& call) const {
    return raw_rpc(channel_, path_of(call), call.messages,
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
  [[noreturn]] static void die(const std::string& why) {
    std::fprintf(stderr, "service: %s\n", why.c_str());
    std::abort();
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

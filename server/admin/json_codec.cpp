// Messages and errors as JSON: the methods that have it, and both ways of translation.
#include "server/admin/json_codec.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/admin/json_text.h"
#include "server/exec/rpc_status.h"
#include "sightline/v1/blob.pb.h"
#include "sightline/v1/query.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"

namespace sightline::server::admin {
namespace {

std::unique_ptr<google::protobuf::Message> make_message(const google::protobuf::Descriptor& type) {
  const auto* prototype =
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type);
  return std::unique_ptr<google::protobuf::Message>(prototype->New());
}

int http_status(Code code) {
  switch (code) {
    case Code::kInvalidArgument:
    case Code::kFailedPrecondition:
    case Code::kOutOfRange:
      return 400;
    case Code::kUnauthenticated:
      return 401;
    case Code::kPermissionDenied:
      return 403;
    case Code::kNotFound:
      return 404;
    case Code::kAlreadyExists:
    case Code::kAborted:
      return 409;
    case Code::kResourceExhausted:
      return 429;
    case Code::kCancelled:
      return 499;
    case Code::kUnimplemented:
      return 501;
    case Code::kUnavailable:
      return 503;
    case Code::kDeadlineExceeded:
      return 504;
    case Code::kUnknown:
    case Code::kInternal:
    case Code::kDataLoss:
      break;
  }
  return 500;
}

}  // namespace

Result<const google::protobuf::MethodDescriptor*> json_method(std::string_view name) {
  for (const auto* file :
       {v1::GetServerInfoRequest::descriptor()->file(), v1::GetSceneRequest::descriptor()->file(),
        v1::CastRaysRequest::descriptor()->file(),
        v1::GetUploadStatusRequest::descriptor()->file()}) {
    for (int at = 0; at < file->service_count(); ++at) {
      const auto* method = file->service(at)->FindMethodByName(std::string(name));
      if (method == nullptr) continue;
      if (!method->client_streaming() && !method->server_streaming()) return method;
      return Error{Code::kUnimplemented,
                   fmt::format("{} is a stream, which only gRPC has", method->name()),
                   "NO_JSON_STREAMS"};
    }
  }
  return Error{Code::kNotFound, fmt::format("there is no call {}", exec::quote(name)),
               "NO_SUCH_CALL"};
}

Result<std::string> message_of_json(const google::protobuf::Descriptor& type,
                                    std::string_view text) {
  if (const Status good = check_json(text); !good) return good.error();
  const auto message = make_message(type);
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(text.data(), text.size()), message.get());
  if (!parsed.ok()) {
    const auto said = parsed.message();
    return exec::invalid_argument(
        fmt::format("the body is no {}: {}", type.name(), std::string(said.data(), said.size())),
        "BAD_JSON");
  }
  return message->SerializeAsString();
}

Result<std::string> json_of_message(const google::protobuf::Descriptor& type,
                                    const std::string& bytes) {
  const auto message = make_message(type);
  std::string text;
  if (!message->ParseFromString(bytes) ||
      !google::protobuf::util::MessageToJsonString(*message, &text).ok())
    return Error{Code::kInternal, fmt::format("the {} has no JSON", type.name()), "UNEXPECTED"};
  return text + "\n";
}

HttpReply json_error(const Error& error) {
  using Json = nlohmann::ordered_json;
  const Json body{{"error",
                   {{"code", name_of(error.code)},
                    {"message", error.message},
                    {"reason", exec::reason_of(error)}}}};
  HttpReply reply;
  reply.code = http_status(error.code);
  reply.type = "application/json";
  // A message may quote a name that is no UTF-8.
  reply.body = body.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  return reply;
}

}  // namespace sightline::server::admin

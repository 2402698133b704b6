// How a call ends: errors as gRPC status, quotes of what the client sent, and a log line.
#include "server/exec/rpc_status.h"

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "proto/printable.h"
#include "server/exec/admission.h"
#include "server/exec/quotas.h"
#include "server/exec/trace_context.h"

namespace sightline::server::exec {
namespace {

grpc::StatusCode grpc_code(Code code) { return static_cast<grpc::StatusCode>(code); }

/// Whether what is refused may be granted later.
bool is_temporary(grpc::StatusCode code, std::string_view reason) {
  return code == grpc::StatusCode::UNAVAILABLE || reason == kQueueFull || reason == kQuotaRays ||
         reason == kQuotaBytes || reason == kQuotaWork;
}

/// The message cut between UTF-8 characters: the text goes into a protobuf string.
std::string cut(const std::string& message) {
  if (message.size() <= kMaxStatusMessage) return message;
  std::size_t end = kMaxStatusMessage;
  while (end > 0 && (static_cast<unsigned char>(message[end]) & 0xc0u) == 0x80u) --end;
  return message.substr(0, end) + "...";
}

}  // namespace

Error invalid_argument(std::string message, std::string reason) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

std::string reason_of(const Error& error) {
  return error.reason.empty() ? name_of(error.code) : error.reason;
}

grpc::Status to_grpc(const Error& error) {
  const grpc::StatusCode code = grpc_code(error.code);
  google::rpc::ErrorInfo info;
  info.set_reason(reason_of(error));
  info.set_domain(kErrorDomain);
  google::rpc::Status status;
  status.set_code(code);
  status.set_message(one_line(cut(error.message)));
  status.add_details()->PackFrom(info);
  if (is_temporary(code, info.reason())) {
    google::rpc::RetryInfo retry;
    *retry.mutable_retry_delay() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
        std::chrono::milliseconds(kRetryDelay).count());
    status.add_details()->PackFrom(retry);
  }
  return {code, status.message(), status.SerializeAsString()};
}

Error error_of(const grpc::Status& status) {
  const bool is_known = status.error_code() > grpc::StatusCode::OK &&
                        status.error_code() <= grpc::StatusCode::UNAUTHENTICATED;
  return {is_known ? static_cast<Code>(status.error_code()) : Code::kUnknown,
          status.error_message(), reason_of(status)};
}

std::string reason_of(const grpc::Status& status) {
  google::rpc::Status details;
  google::rpc::ErrorInfo info;
  if (!details.ParseFromString(status.error_details())) return {};
  for (const auto& detail : details.details()) {
    if (detail.UnpackTo(&info)) return info.reason();
  }
  return {};
}

bool asks_to_retry(const grpc::Status& status) {
  if (status.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED) return false;
  google::rpc::Status details;
  return details.ParseFromString(status.error_details()) &&
         std::any_of(details.details().begin(), details.details().end(), [](const auto& detail) {
           return detail.template Is<google::rpc::RetryInfo>();
         });
}

grpc::Status to_grpc(const Status& status) {
  return status.ok() ? grpc::Status::OK : to_grpc(status.error());
}

std::string quote(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kMaxQuoted)) {
    if (c == '"' || c == '\\') out += '\\';
    out += is_printable(c) ? c : '?';
  }
  out += '"';
  if (text.size() > kMaxQuoted) out += fmt::format("... ({} bytes)", text.size());
  return out;
}

std::string call_ids_of(const grpc::ServerContextBase& context) {
  std::string ids;
  const auto& metadata = context.client_metadata();
  const auto request = metadata.find(kRequestId);
  if (request != metadata.end())
    ids += " request_id=" + quote({request->second.data(), request->second.size()});
  const auto [first, last] = metadata.equal_range(kTraceParent);
  if (first == last || std::next(first) != last) return ids;
  const std::string_view trace = parse_trace_id({first->second.data(), first->second.size()});
  if (!trace.empty()) ids.append(" trace_id=").append(trace);
  return ids;
}

bool logs_rpcs() { return spdlog::should_log(spdlog::level::debug); }

void log_rpc(std::string_view method, const grpc::ServerContextBase& context,
             const grpc::Status& status, LogClock::time_point begun, std::string_view more) {
  if (!logs_rpcs()) return;
  const auto us =
      std::chrono::duration_cast<std::chrono::microseconds>(LogClock::now() - begun).count();
  const auto code = static_cast<int>(status.error_code());
  if (status.ok()) {
    spdlog::debug("event=rpc method={} code={} us={}{} {}", method, code, us, call_ids_of(context),
                  more);
  } else {
    spdlog::debug("event=rpc method={} code={} us={}{} error={} {}", method, code, us,
                  call_ids_of(context), quote(status.error_message()), more);
  }
}

}  // namespace sightline::server::exec

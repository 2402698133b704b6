// An interceptor for single requests. A mark in the message for streams: parsing removes it.
#include "server/exec/malformed.h"

#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/unknown_field_set.h>

#include "server/exec/rpc_status.h"

namespace sightline::server::exec {
namespace {

namespace experimental = grpc::experimental;

// Statuses of our own always have details, and all methods of our services are implemented.
bool is_from_grpc(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNIMPLEMENTED && status.error_details().empty();
}

class Interceptor final : public experimental::Interceptor {
 public:
  void Intercept(experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(
            experimental::InterceptionHookPoints::PRE_SEND_STATUS) &&
        is_from_grpc(methods->GetSendStatus()))
      methods->ModifySendStatus(to_grpc(malformed_message()));
    methods->Proceed();
  }
};

class Factory final : public experimental::ServerInterceptorFactoryInterface {
 public:
  experimental::Interceptor* CreateServerInterceptor(experimental::ServerRpcInfo* call) override {
    return call->type() == experimental::ServerRpcInfo::Type::UNARY
               ? std::make_unique<Interceptor>().release()
               : nullptr;
  }
};

constexpr int kMark = 1;

google::protobuf::UnknownFieldSet& unknown_fields(google::protobuf::Message& message) {
  return *message.GetReflection()->MutableUnknownFields(&message);
}

}  // namespace

Error malformed_message() {
  return invalid_argument(
      "the request is no message of its type; a string that is not UTF-8 is a cause",
      "MALFORMED_MESSAGE");
}

std::unique_ptr<experimental::ServerInterceptorFactoryInterface> refuse_malformed() {
  // The handler writes a line to standard error for each bad string, and blocks if a pipe there is
  // full.
  google::protobuf::SetLogHandler(nullptr);
  return std::make_unique<Factory>();
}

void free_if_large(google::protobuf::Message& message) {
  if (message.ByteSizeLong() <= kIdleMessage) return;
  const std::unique_ptr<google::protobuf::Message> fresh(message.New());
  message.GetReflection()->Swap(&message, fresh.get());
}

void before_read(google::protobuf::Message& message) {
  free_if_large(message);
  message.Clear();
  unknown_fields(message).AddVarint(kMark, 0);
}

Status end_of_reads(const google::protobuf::Message& message) {
  const auto& unknown = message.GetReflection()->GetUnknownFields(message);
  const bool is_untouched = unknown.field_count() == 1 && unknown.field(0).number() == kMark &&
                            unknown.field(0).type() == google::protobuf::UnknownField::TYPE_VARINT;
  return is_untouched ? Status() : Status(malformed_message());
}

}  // namespace sightline::server::exec

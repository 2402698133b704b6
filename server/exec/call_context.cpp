// The context of a call: what gRPC knows of it, and its principal.
#include "server/exec/call_context.h"

#include <grpc/grpc.h>
#include <grpcpp/generic/async_generic_service.h>

#include <vector>

namespace sightline::server::exec {
namespace {

class Allocator final : public grpc::ContextAllocator {
 public:
  explicit Allocator(CallContexts& calls) : calls_(calls) {}
  grpc::CallbackServerContext* NewCallbackServerContext() override {
    return new CallContext(calls_);
  }
  /// Makes the context of a call of a method that does not exist.
  grpc::GenericCallbackServerContext* NewGenericCallbackServerContext() override {
    return new grpc::GenericCallbackServerContext();
  }
  void Release(grpc::CallbackServerContext* context) override { delete context; }
  void Release(grpc::GenericCallbackServerContext* context) override { delete context; }

 private:
  CallContexts& calls_;
};

}  // namespace

void CallContexts::add(CallContext& context) {
  const std::lock_guard lock(mutex_);
  open_.insert(&context);
}

void CallContexts::remove(CallContext& context) {
  if (context.principal() == nullptr) return;
  const std::lock_guard lock(mutex_);
  open_.erase(&context);
}

void CallContexts::end_outdated(const Current& current) {
  std::vector<grpc_call*> outdated;
  {
    const std::lock_guard lock(mutex_);
    for (CallContext* context : open_) {
      if (current(*context) == context->principal()) continue;
      outdated.push_back(context->c_call());
      grpc_call_ref(outdated.back());
    }
  }
  // The lock is not held: the end of a call may run in this thread, and removes its context.
  for (grpc_call* call : outdated) {
    grpc_call_cancel_with_status(call, GRPC_STATUS_UNAUTHENTICATED,
                                 "the token of this call is not valid any more", nullptr);
    grpc_call_unref(call);
  }
}

std::unique_ptr<grpc::ContextAllocator> make_contexts(CallContexts& calls) {
  return std::make_unique<Allocator>(calls);
}

const Principal* principal_of(const grpc::ServerContextBase& context) {
  const auto* call = dynamic_cast<const CallContext*>(&context);
  return call != nullptr ? call->principal().get() : nullptr;
}

Status check_role(const grpc::ServerContextBase& context, Role role) {
  const Principal* principal = principal_of(context);
  return principal != nullptr ? principal->check(role) : Status();
}

Status check_role(const grpc::ServerContextBase& context, Role role, std::string_view scene) {
  const Principal* principal = principal_of(context);
  return principal != nullptr ? principal->check(role, scene) : Status();
}

}  // namespace sightline::server::exec

// The context of a call: what gRPC knows of it, and its principal.
#pragma once

#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>

#include "server/exec/principal.h"

namespace sightline::server::exec {

class CallContext;

/// The calls that are open. Threads: any, for every member.
class CallContexts {
 public:
  using Current = std::function<std::shared_ptr<const Principal>(CallContext&)>;

  void add(CallContext& context);
  /// After it returns, the context is not used any more.
  void remove(CallContext& context);
  /// Ends the calls whose principal is not the one that current() returns now, with UNAUTHENTICATED
  /// if no reply was sent yet. Calls without a principal stay. current() must call no member of
  /// this.
  void end_outdated(const Current& current);

 private:
  std::mutex mutex_;
  std::set<CallContext*> open_;
};

/// gRPC makes one for each call with the allocator below. The principal is set before anything else
/// is done for the call, and stays.
class CallContext final : public grpc::CallbackServerContext {
 public:
  explicit CallContext(CallContexts& calls) : calls_(calls) {}
  CallContext(const CallContext&) = delete;
  CallContext& operator=(const CallContext&) = delete;
  ~CallContext() override { calls_.remove(*this); }

  /// Null: the server does not ask who calls, and every caller may do everything.
  const std::shared_ptr<const Principal>& principal() const { return principal_; }
  void set_principal(std::shared_ptr<const Principal> principal) {
    principal_ = std::move(principal);
    if (principal_ != nullptr) calls_.add(*this);
  }

 private:
  CallContexts& calls_;
  std::shared_ptr<const Principal> principal_;
};

/// An allocator for grpc::ServerBuilder: every call of the server gets a CallContext. `calls`
/// outlives the server.
std::unique_ptr<grpc::ContextAllocator> make_contexts(CallContexts& calls);

/// The principal of a call; null if it has none.
const Principal* principal_of(const grpc::ServerContextBase& context);

/// Whether the principal of a call may do this. Errors: see Principal::check().
Status check_role(const grpc::ServerContextBase& context, Role role);
Status check_role(const grpc::ServerContextBase& context, Role role, std::string_view scene);

}  // namespace sightline::server::exec

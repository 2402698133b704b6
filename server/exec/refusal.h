// A call that is refused before anything is done for it.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::exec {

/// Ends a call of any kind at once. Deletes itself.
template <class Reactor>
class RefusedCall final : public Reactor {
 public:
  explicit RefusedCall(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

/// Becomes the reactor that a method must return.
class Refusal {
 public:
  explicit Refusal(const Error& error) : status_(to_grpc(error)) {}

  template <class Reactor>
  operator Reactor*() const {
    return new RefusedCall<Reactor>(status_);
  }

 private:
  const grpc::Status status_;
};

}  // namespace sightline::server::exec

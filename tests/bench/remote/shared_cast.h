// Casts rays through memory that client and server share.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/client.h"
#include "proto/result.h"
#include "tests/bench/remote/remote_cast.h"

namespace sightline::bench {

/// Rays and answers of one client, in memory that the server has, too. Rays that the server makes
/// are not there. Threads: one.
class SharedCast {
 public:
  /// `rays` outlive this. Errors: kFailedPrecondition, also where the server shares no memory.
  static Result<std::unique_ptr<SharedCast>> make(const RemoteRays& rays, const RemoteLoad& load);

  /// Errors: kFailedPrecondition.
  Status cast();
  /// Copies the answers.
  void copy_to(RemoteHits& hits) const;

 private:
  SharedCast(client::Client client, const RemoteRays& rays, const RemoteLoad& load)
      : client_(std::move(client)), rays_(rays), load_(load) {}
  Status allocate();
  template <class T>
  std::span<T> array(std::size_t count);

  client::Client client_;
  const RemoteRays& rays_;
  const RemoteLoad load_;
  std::vector<client::SharedMemory> memory_;
  std::vector<std::shared_ptr<void>> arrays_;
  client::RayColumns<const float> columns_;
  client::HitColumns hits_;
  Status failed_;  // of array()
};

}  // namespace sightline::bench

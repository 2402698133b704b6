// Sends requests of rays, and updates between them, to a server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/client.h"
#include "client/load/moving_copy.h"
#include "client/load/ray_set.h"
#include "client/load/target.h"

namespace sightline::client::load {

/// Whether request k is an update, if this share (0 to 1) of all is: evenly spread.
bool is_update(std::uint64_t request, double share);

class CastTarget final : public Target {
 public:
  struct Options {
    std::string scene;
    CastOptions cast{};  ///< `stop` is that of the run
    std::size_t batch = 0;
    double updates = 0;
  };

  /// Worker k uses clients[k % n]. `copy` may be null if there are no updates. All must outlive it.
  CastTarget(const std::vector<Client>& clients, const RaySet& rays, MovingCopy* copy,
             std::size_t workers, Options options);

  Outcome send(std::size_t worker, std::uint64_t request, const std::stop_token& stop) override;

 private:
  // Memory for answers, of one worker.
  struct Answers {
    std::vector<double> t;
    std::vector<std::uint64_t> node;
    std::vector<std::uint32_t> primitive, count;
    std::vector<std::uint8_t> hit_bits;

    void resize(QueryKind kind, std::size_t rays);
    HitColumns columns();
  };

  template <class Scalar>
  Result<CastReport> cast(const Client& client, const RayColumns<const Scalar>& rays,
                          Answers& answers, const std::stop_token& stop) const;
  Outcome update(const Client& client, const std::stop_token& stop);

  const std::vector<Client>& clients_;
  const Batches batches_;
  MovingCopy* const copy_;
  const Options options_;
  std::vector<Answers> answers_;  // by worker
};

}  // namespace sightline::client::load

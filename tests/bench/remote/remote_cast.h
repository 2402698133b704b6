// Casts rays over the network, with several clients at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "client/cast_options.h"
#include "proto/result.h"
#include "tests/bench/remote/remote_rays.h"

namespace sightline::bench {

/// What is answered about each ray.
enum class RemoteAnswer : std::uint8_t {
  kRich,  ///< t, node, primitive, weights and normal.
  kT,     ///< t alone.
  kBits,  ///< One bit: whether there is a hit.
};

/// Every row of an answer. Columns that are not asked for are empty.
struct RemoteHits {
  RemoteHits(RemoteAnswer answer, std::size_t rays);
  client::HitColumns columns();
  /// Errors: kDataLoss, naming the first ray whose answer is another.
  Status compare(std::span<const accel::geometry::Hit> expected) const;

  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> barycentric, normal;
  std::vector<std::uint8_t> bits;
};

struct RemoteLoad {
  std::string endpoint;
  int clients = 1;           ///< Each with a connection and a stream of its own.
  std::size_t batch = 8192;  ///< Rays of a message, at most client::kRaysPerMessage.
  RemoteAnswer answer = RemoteAnswer::kRich;
  bool points = false;    ///< Asks for the faces nearest to the rays' origins, within tmax.
  bool segments = false;  ///< See SharedCast.
};

/// Casts all rays, each client an equal part of them. `batch_us` gets the time from each message's
/// filling to its answer, unless the rays are generated. Errors: kFailedPrecondition.
Status cast_remotely(const RemoteRays& rays, const RemoteLoad& load, RemoteHits& hits,
                     std::vector<double>& batch_us);

}  // namespace sightline::bench

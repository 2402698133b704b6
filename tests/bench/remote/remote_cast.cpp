// Casts rays over the network, with several clients at a time.
#include "tests/bench/remote/remote_cast.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <mutex>
#include <thread>

#include "client/client.h"
#include "proto/rays/generated_rays.h"
#include "tests/bench/remote/upload.h"

namespace sightline::bench {
namespace {

using Clock = std::chrono::steady_clock;
using accel::geometry::Hit;

/// A part of the rays; a multiple of eight before it, so that it begins a byte of bits.
struct Part {
  std::size_t first, count;
};

template <class T>
std::span<T> rows(std::span<T> column, const Part& part, std::size_t width = 1) {
  return column.empty() ? column : column.subspan(width * part.first, width * part.count);
}

client::HitColumns part_of(const client::HitColumns& hits, const Part& part) {
  client::HitColumns out{.t = rows(hits.t, part),
                         .node = rows(hits.node, part),
                         .primitive = rows(hits.primitive, part),
                         .barycentric = rows(hits.barycentric, part, 2),
                         .normal = rows(hits.normal, part, 3)};
  if (!hits.hit_bits.empty()) {
    out.hit_bits =
        hits.hit_bits.subspan(client::bits_bytes(part.first), client::bits_bytes(part.count));
  }
  return out;
}

client::CastOptions options_of(RemoteAnswer answer) {
  return {.kind = answer == RemoteAnswer::kBits ? client::QueryKind::kAny
                                                : client::QueryKind::kClosest};
}

/// Copies columns of answers behind the rows that are there.
void copy(const client::HitView& from, std::size_t first, const client::HitColumns& to) {
  const auto put = [first](auto rows, auto column, std::size_t width) {
    std::copy(rows.begin(), rows.end(),
              column.begin() + static_cast<std::ptrdiff_t>(first * width));
  };
  put(from.t, to.t, 1);
  put(from.node, to.node, 1);
  put(from.primitive, to.primitive, 1);
  put(from.barycentric, to.barycentric, 2);
  put(from.normal, to.normal, 3);
  if (!to.hit_bits.empty())
    std::copy(from.hit_bits.begin(), from.hit_bits.end(),
              to.hit_bits.begin() + static_cast<std::ptrdiff_t>(client::bits_bytes(first)));
}

/// One stream, in messages of `batch` rays.
client::Result<client::CastReport> cast_sent(const client::Client& client,
                                             const client::RayColumns<const float>& rays,
                                             const RemoteLoad& load, const client::HitColumns& hits,
                                             std::vector<double>& batch_us) {
  const std::size_t n = rays.size();
  std::vector<Clock::time_point> filled(n / load.batch + 1);
  client::RaySource<float> source =
      [&, sent = std::size_t{0}](
          const client::RayColumns<float>& out) mutable -> client::Result<std::size_t> {
    const std::size_t count = std::min(load.batch, n - sent);
    if (count > 0) filled[sent / load.batch] = Clock::now();
    const auto take = [&](auto from, auto to, std::size_t width) {
      if (!from.empty() && !to.empty())
        std::copy_n(from.data() + width * sent, width * count, to.data());
    };
    take(rays.origins, out.origins, 3);
    take(rays.directions, out.directions, 3);
    take(rays.tmin, out.tmin, 1);
    take(rays.tmax, out.tmax, 1);
    sent += count;
    return count;
  };
  const client::HitSink sink = [&](std::uint64_t first, std::size_t, const client::HitView& view) {
    copy(view, first, hits);
    const std::chrono::duration<double, std::micro> time =
        Clock::now() - filled[first / load.batch];
    batch_us.push_back(time.count());
    return client::Status();
  };
  const client::HitFields fields{.t = !hits.t.empty(),
                                 .node = !hits.node.empty(),
                                 .primitive = !hits.primitive.empty(),
                                 .barycentric = !hits.barycentric.empty(),
                                 .normal = !hits.normal.empty(),
                                 .hit_bits = !hits.hit_bits.empty()};
  const bool limited = !rays.tmin.empty();
  if (!load.points) {
    return client.cast_stream(kRemoteScene, source, {.interval = limited}, fields, sink,
                              options_of(load.answer));
  }
  const client::PointSource<float> points = [&](const client::PointColumns<float>& out) {
    return source({out.positions, {}, {}, out.max_distance, {}});
  };
  return client.nearest_stream(kRemoteScene, points, {.max_distance = limited}, fields, sink,
                               options_of(load.answer));
}

client::Result<client::CastReport> cast_part(const RemoteRays& rays, const RemoteLoad& load,
                                             const Part& part, const client::HitColumns& hits,
                                             std::vector<double>& batch_us) {
  const auto client = client::Client::connect(load.endpoint);
  if (!client) return client.error();
  if (rays.generated) {
    client::RayGenerator generator = rays.generator;
    generator.first = part.first;
    generator.count = part.count;
    return client->cast_stream(kRemoteScene, generator, hits, options_of(load.answer));
  }
  const auto all = rays.columns();
  return cast_sent(*client,
                   {rows(all.origins, part, 3),
                    rows(all.directions, part, 3),
                    rows(all.tmin, part),
                    rows(all.tmax, part),
                    {}},
                   load, hits, batch_us);
}

bool same(const Hit& expected, const RemoteHits& hits, std::size_t i) {
  const bool is_hit = expected.state == accel::geometry::HitState::kHit;
  if (!hits.bits.empty()) return ((hits.bits[i / 8] >> (i % 8)) & 1) == (is_hit ? 1 : 0);
  if (std::bit_cast<std::uint64_t>(hits.t[i]) != std::bit_cast<std::uint64_t>(expected.t))
    return false;
  if (hits.node.empty()) return true;
  return hits.node[i] == expected.node && hits.primitive[i] == expected.primitive &&
         hits.barycentric[2 * i] == expected.u && hits.barycentric[2 * i + 1] == expected.v &&
         hits.normal[3 * i] == expected.normal.x && hits.normal[3 * i + 2] == expected.normal.z;
}

}  // namespace

RemoteHits::RemoteHits(RemoteAnswer answer, std::size_t rays) {
  if (answer == RemoteAnswer::kBits) {
    bits.resize(client::bits_bytes(rays));
    return;
  }
  t.resize(rays);
  if (answer == RemoteAnswer::kT) return;
  node.resize(rays);
  primitive.resize(rays);
  barycentric.resize(2 * rays);
  normal.resize(3 * rays);
}

client::HitColumns RemoteHits::columns() {
  return {.t = t,
          .node = node,
          .primitive = primitive,
          .barycentric = barycentric,
          .normal = normal,
          .hit_bits = bits};
}

Status RemoteHits::compare(std::span<const Hit> expected) const {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!same(expected[i], *this, i)) {
      return Error{Code::kDataLoss, fmt::format("the server answers ray {} differently", i),
                   "ANSWERS_DIFFER"};
    }
  }
  return {};
}

Status cast_remotely(const RemoteRays& rays, const RemoteLoad& load, RemoteHits& hits,
                     std::vector<double>& batch_us) {
  const std::size_t n = rays.in_process.size();
  const auto clients = static_cast<std::size_t>(load.clients);
  const std::size_t share = (n / clients + 7) / 8 * 8;
  std::mutex mutex;
  Status failed;
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < clients; ++k) {
    threads.emplace_back([&, k] {
      const std::size_t first = std::min(k * share, n);
      const Part part{first, k + 1 == clients ? n - first : std::min(share, n - first)};
      if (part.count == 0) return;
      std::vector<double> times;
      const auto report = cast_part(rays, load, part, part_of(hits.columns(), part), times);
      const std::lock_guard lock(mutex);
      if (!report) failed = error_of(report.error());
      batch_us.insert(batch_us.end(), times.begin(), times.end());
    });
  }
  for (std::thread& thread : threads) thread.join();
  return failed;
}

}  // namespace sightline::bench

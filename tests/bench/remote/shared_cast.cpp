// Casts rays through memory that client and server share.
#include "tests/bench/remote/shared_cast.h"

#include <algorithm>
#include <utility>

#include "tests/bench/remote/upload.h"

namespace sightline::bench {
namespace {

/// What the size of a column may be rounded up by.
constexpr std::size_t kRounding = 64;

template <class T>
std::size_t bytes_of(std::span<const T> column) {
  return column.size_bytes() + kRounding;
}

}  // namespace

Result<std::unique_ptr<SharedCast>> SharedCast::make(const RemoteRays& rays,
                                                     const RemoteLoad& load) {
  auto client = client::Client::connect(load.endpoint);
  if (!client) return error_of(client.error());
  std::unique_ptr<SharedCast> made(new SharedCast(*std::move(client), rays, load));
  if (Status done = made->allocate(); !done) return done.error();
  return made;
}

template <class T>
std::span<T> SharedCast::array(std::size_t count) {
  if (count == 0 || !failed_) return {};
  auto made = memory_.back().array<T>(count);
  if (!made) {
    failed_ = error_of(made.error());
    return {};
  }
  auto kept = std::make_shared<client::SharedArray<T>>(*std::move(made));
  const std::span<T> span = kept->span();
  arrays_.push_back(std::move(kept));
  return span;
}

Status SharedCast::allocate() {
  RemoteHits plain(load_.answer, rays_.in_process.size());
  const client::HitColumns asked = plain.columns();
  const auto rays = rays_.columns();
  const std::size_t bytes =
      bytes_of(rays.origins) + bytes_of(rays.directions) + bytes_of(rays.tmin) +
      bytes_of(rays.tmax) + bytes_of<double>(asked.t) + bytes_of<std::uint64_t>(asked.node) +
      bytes_of<std::uint32_t>(asked.primitive) + bytes_of<float>(asked.barycentric) +
      bytes_of<float>(asked.normal) + bytes_of<std::uint8_t>(asked.hit_bits);
  auto memory = client_.share_memory(bytes);
  if (!memory) return error_of(memory.error());
  memory_.push_back(*std::move(memory));
  if (!memory_.back().is_shared())
    return Error{Code::kFailedPrecondition, memory_.back().why_not_shared(), "NOT_SHARED"};
  const auto copied = [this](std::span<const float> from) -> std::span<const float> {
    const std::span<float> to = array<float>(from.size());
    std::copy_n(from.begin(), to.size(), to.begin());
    return to;
  };
  columns_ = {
      copied(rays.origins), copied(rays.directions), copied(rays.tmin), copied(rays.tmax), {}};
  hits_ = {.t = array<double>(asked.t.size()),
           .node = array<std::uint64_t>(asked.node.size()),
           .primitive = array<std::uint32_t>(asked.primitive.size()),
           .barycentric = array<float>(asked.barycentric.size()),
           .normal = array<float>(asked.normal.size())};
  hits_.hit_bits = array<std::uint8_t>(asked.hit_bits.size());
  return failed_;
}

Status SharedCast::cast() {
  const client::CastOptions options{.kind = load_.answer == RemoteAnswer::kBits
                                                ? client::QueryKind::kAny
                                                : client::QueryKind::kClosest};
  const auto report = [&] {
    if (rays_.generated) return client_.cast_stream(kRemoteScene, rays_.generator, hits_, options);
    if (!load_.points) return client_.cast_stream(kRemoteScene, columns_, hits_, options);
    const client::PointColumns<const float> points{.positions = columns_.origins,
                                                   .max_distance = columns_.tmax};
    return client_.nearest_stream(kRemoteScene, points, hits_, options);
  }();
  return report ? Status() : Status(error_of(report.error()));
}

void SharedCast::copy_to(RemoteHits& hits) const {
  const client::HitColumns to = hits.columns();
  const auto copy = [](auto from, auto into) {
    std::copy_n(from.begin(), into.size(), into.begin());
  };
  copy(hits_.t, to.t);
  copy(hits_.node, to.node);
  copy(hits_.primitive, to.primitive);
  copy(hits_.barycentric, to.barycentric);
  copy(hits_.normal, to.normal);
  copy(hits_.hit_bits, to.hit_bits);
}

}  // namespace sightline::bench

// One request is one message with one batch.
#include "client/load/cast_target.h"

#include <cmath>
#include <utility>

namespace sightline::client::load {
namespace {

Outcome outcome_of(const Error& error, const std::stop_token& stop) {
  Outcome outcome;
  outcome.error = error.message;
  if (stop.stop_requested()) {
    outcome.state = Outcome::State::kCancelled;
  } else {
    outcome.state =
        error.code == Code::kResourceExhausted ? Outcome::State::kRefused : Outcome::State::kFailed;
  }
  return outcome;
}

}  // namespace

bool is_update(std::uint64_t request, double share) {
  const auto before = [&](std::uint64_t count) {
    return std::floor(static_cast<double>(count) * share);
  };
  return before(request + 1) > before(request);
}

void CastTarget::Answers::resize(QueryKind kind, std::size_t rays) {
  if (kind == QueryKind::kClosest) {
    t.resize(rays);
    node.resize(rays);
    primitive.resize(rays);
  } else if (kind == QueryKind::kAny) {
    hit_bits.resize(bits_bytes(rays));
  } else if (kind == QueryKind::kCount) {
    count.resize(rays);
  }
}

HitColumns CastTarget::Answers::columns() {
  return {.t = t, .node = node, .primitive = primitive, .count = count, .hit_bits = hit_bits};
}

CastTarget::CastTarget(const std::vector<Client>& clients, const RaySet& rays, MovingCopy* copy,
                       std::size_t workers, Options options)
    : clients_(clients),
      batches_(rays, options.batch),
      copy_(copy),
      options_(std::move(options)),
      answers_(workers) {}

Outcome CastTarget::send(std::size_t worker, std::uint64_t request, const std::stop_token& stop) {
  const Client& client = clients_[worker % clients_.size()];
  if (copy_ != nullptr && is_update(request, options_.updates)) return update(client, stop);
  const auto report = batches_.with(
      request, [&](const auto& rays) { return cast(client, rays, answers_[worker], stop); });
  if (!report) return outcome_of(report.error(), stop);
  Outcome outcome;
  outcome.rays = report->rays;
  outcome.hits = report->hits;
  outcome.queue_us = report->queue_us;
  outcome.build_us = report->build_us;
  outcome.trace_us = report->trace_us;
  return outcome;
}

template <class Scalar>
Result<CastReport> CastTarget::cast(const Client& client, const RayColumns<const Scalar>& rays,
                                    Answers& answers, const std::stop_token& stop) const {
  CastOptions options = options_.cast;
  options.stop = stop;
  if (options.kind == QueryKind::kAll) {
    auto all = client.cast_all(options_.scene, rays, {.t = true, .node = true, .primitive = true},
                               options);
    if (!all) return all.error();
    return std::move(all->report);
  }
  answers.resize(options.kind, rays.size());
  return client.cast(options_.scene, rays, answers.columns(), options);
}

Outcome CastTarget::update(const Client& client, const std::stop_token& stop) {
  const Status moved = copy_->move(client);
  Outcome outcome = moved ? Outcome{} : outcome_of(moved.error(), stop);
  outcome.is_update = true;
  return outcome;
}

}  // namespace sightline::client::load

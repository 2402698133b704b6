// One batch of rays on its way through the server.
#include "server/cast_job.h"

#include <utility>

#include "server/names.h"

namespace sightline::server {
namespace {

/// With every field asked for.
constexpr std::size_t kReplyBytesPerRay = 48;

std::uint64_t microseconds(std::chrono::steady_clock::duration time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time).count());
}

}  // namespace

Status CastJob::open(const v1::CastRaysRequest& request) {
  if (Status good = check_scene_name(request.scene()); !good) return good;
  auto query = decode_query(request, services_.policy);
  if (!query) return query.error();
  const auto scene = services_.scenes.get(request.scene());
  if (!scene) return scene.error();
  query_ = std::move(*query);
  snapshot_ = (*scene)->scene().snapshot();
  return {};
}

Status CastJob::take(const v1::Rays& rays) {
  if (Status decoded = decode_rays(rays, rays_); !decoded) return decoded;
  const std::size_t bytes_per_ray = sizeof(accel::Ray) + sizeof(accel::Hit) + kReplyBytesPerRay;
  auto ticket =
      services_.admission.admit(rays_.size(), rays.ByteSizeLong() + rays_.size() * bytes_per_ray);
  if (!ticket) return ticket.error();
  ticket_ = std::move(*ticket);
  taken_ = Clock::now();
  return {};
}

Status CastJob::run(v1::CastRaysResponse& reply) {
  // Given back before the reply is written: a client that is slow to read must not hold up the
  // others.
  const Admission::Ticket ticket = std::move(ticket_);
  const auto begun = Clock::now();
  hits_.resize(rays_.size());
  const auto traced = scenegraph::trace(*snapshot_, rays_, hits_,
                                        {.kind = query_.kind,
                                         .growth = query_.growth,
                                         .surface = query_.surface,
                                         .cancelled = &cancelled_});
  if (!traced) return traced.error();
  reply.mutable_served()->set_revision(snapshot_->revision());
  encode_hits(hits_, query_.fields, reply);
  v1::CastStats& stats = *reply.mutable_stats();
  encode_stats(*traced, stats);
  stats.set_queue_us(microseconds(begun - taken_));
  stats.set_trace_us(microseconds(Clock::now() - begun));
  return {};
}

}  // namespace sightline::server

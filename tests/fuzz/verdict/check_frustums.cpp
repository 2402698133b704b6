#include "tests/fuzz/verdict/check_frustums.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <tuple>

#include <fmt/format.h>

#include "accel/geometry/local_ray.h"
#include "accel/wide/frustum.h"
#include "tests/fuzz/verdict/check_packets.h"
#include "tests/fuzz/verdict/exact_answers.h"

namespace sightline::tests {

namespace wide = accel::wide;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

namespace {

/// Rays of a case as a frustum around one of them.
class FrustumCase {
 public:
  FrustumCase(const VerdictCase& from, std::size_t first, bool toward)
      : from_(from), at_(from.rays[first].ray.origin), toward_(toward) {
    out_.vertices = from.vertices;
    out_.faces = from.faces;
    out_.culling = from.culling;
    for (std::size_t i = 0; i < from.rays.size(); ++i) {
      const AskedRay& ray = from.rays[(first + i) % from.rays.size()];
      add(ray.ray.direction, ray);
    }
    for (std::size_t i = 0; i < from.vertices.size(); ++i)
      add(Vec3d(from.vertices[i]) - at_, of(i));
    for (std::size_t i = 0; i < from.faces.size(); ++i) add(middle(i) - at_, of(i));
  }

  const VerdictCase& made() const { return out_; }

 private:
  const AskedRay& of(std::size_t i) const { return from_.rays[i % from_.rays.size()]; }

  Vec3d middle(std::size_t face) const {
    const accel::geometry::Face& f = from_.faces[face];
    return (Vec3d(from_.vertices[f[0]]) + Vec3d(from_.vertices[f[1]]) +
            Vec3d(from_.vertices[f[2]])) *
           (1.0 / 3);
  }

  /// With the limits and the best hit of a ray, as far as a frustum may have them.
  void add(const Vec3d& along, const AskedRay& like) {
    AskedRay ray = like;
    ray.ray.origin = toward_ ? at_ + along * 1.5 : at_;
    ray.ray.direction = toward_ ? at_ - ray.ray.origin : along;
    if (out_.rays.size() == wide::kFrustumPackets * wide::kLanes ||
        !accel::geometry::make_local_ray(ray.ray.origin, ray.ray.direction))
      return;
    ray.ray.tmin = std::max(ray.ray.tmin, 0.0);
    if (toward_) ray.ray.tmax = std::min(ray.ray.tmax, 1.0);
    if (toward_ || !(ray.best_t >= ray.ray.tmin && ray.best_t <= ray.ray.tmax)) {
      ray.has_best = false;
      ray.best_t = AskedRay{}.best_t;
      ray.best_node = AskedRay{}.best_node;
    }
    out_.rays.push_back(ray);
  }

  const VerdictCase& from_;
  const Vec3d at_;
  const bool toward_;
  VerdictCase out_;
};

/// The packets of a frustum.
class FrustumAsking {
 public:
  FrustumAsking(const VerdictCase& asked, const VerdictTree& tree, bool any)
      : asked_(asked), any_(any) {
    for (std::size_t first = 0, p = 0; first < asked.rays.size(); first += wide::kLanes, ++p) {
      VerdictCase part;
      part.culling = asked.culling;
      const std::size_t end = std::min(first + wide::kLanes, asked.rays.size());
      for (std::size_t i = first; i < end; ++i) part.rays.push_back(asked.rays[i]);
      PreparedPacket packet;
      prepare_packet(part, tree, any, packet);
      packets_.push_back(*packet.packet);
      best_.push_back(std::move(packet.best));
      lanes_[p] = (2u << (part.rays.size() - 1)) - 1;
    }
    for (std::size_t p = 0; p < packets_.size(); ++p) packets_[p].best = best_[p].get();
  }

  std::optional<std::string> walk(const VerdictTree& tree, const wide::WideTree& walked,
                                  const ExactAnswers& exact, std::uint64_t& done) {
    accel::kdtree::WalkCounters counters;
    const wide::FrustumLanes answered = wide::walk_frustum(
        packets_, tree.frame(), wide::Child::final(walked.root()), lanes_, counters);
    for (std::size_t i = 0; i < asked_.rays.size(); ++i) {
      const bool is_done = answered[i / wide::kLanes] >> i % wide::kLanes & 1;
      done += is_done ? 1 : 0;
      if (const char* wrong = check(i, is_done, exact.best(i, any_)))
        return fmt::format("{} hit: ray {}: {}", any_ ? "any" : "nearest", i, wrong);
    }
    return std::nullopt;
  }

 private:
  const char* check(std::size_t i, bool is_done, const ExactBest& exact) const {
    const wide::BestHits& best = *best_[i / wide::kLanes];
    const std::size_t lane = i % wide::kLanes;
    const ExactBest answer{(best.found >> lane & 1) != 0, best.t[lane], best.node[lane],
                           best.primitive[lane]};
    if (any_) {
      if (answer.found && !exact.found) return "finds a miss";
      return is_done && exact.found && !answer.found ? "misses a hit" : nullptr;
    }
    if (is_done) return answer == exact ? nullptr : "has another hit";
    const auto order = [](const ExactBest& x) { return std::tuple(x.t, x.node, x.primitive); };
    return order(answer) < order(exact) ? "knows too much of a ray that is not done" : nullptr;
  }

  const VerdictCase& asked_;
  const bool any_;
  std::vector<wide::Packet> packets_;
  std::vector<std::unique_ptr<wide::BestHits>> best_;
  wide::FrustumLanes lanes_{};
};

}  // namespace

std::optional<std::string> check_frustums(const VerdictCase& asked, const VerdictTree& tree,
                                          std::uint64_t& done) {
  for (const std::size_t first : {std::size_t{0}, asked.rays.size() / 2}) {
    for (const bool toward : {false, true}) {
      const FrustumCase frustum(asked, first, toward);
      if (frustum.made().rays.empty()) continue;
      const ExactAnswers exact(frustum.made());
      for (const wide::WideTree* walked : {&tree.single(), &tree.dense()}) {
        for (const bool any : {false, true}) {
          if (toward && !any) continue;
          auto wrong = FrustumAsking(frustum.made(), tree, any).walk(tree, *walked, exact, done);
          if (wrong)
            return fmt::format("frustum {} the origin of ray {}, {}", toward ? "toward" : "from",
                               first, *wrong);
        }
      }
    }
  }
  return std::nullopt;
}

}  // namespace sightline::tests

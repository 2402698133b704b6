// The rays that a run casts, over and over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <variant>
#include <vector>

#include "client/cast_options.h"

namespace sightline::client::load {

struct Ray {
  std::array<double, 3> origin{};
  std::array<double, 3> direction{};
  double tmin = 0;
  double tmax = std::numeric_limits<double>::infinity();
};

/// Columns of rays in the precision in which they are sent. Threads: any may read.
class RaySet {
 public:
  RaySet() = default;
  enum class Precision : std::uint8_t { kFloat, kDouble };
  static RaySet of(std::span<const Ray> rays, Precision precision);

  /// All rays in the precision of the columns.
  template <class Scalar>
  static RaySet copy(const RayColumns<const Scalar>& rays);
  /// Adds rays of the same precision.
  template <class Scalar>
  void append(const RayColumns<const Scalar>& rays);

  std::size_t size() const;
  Ray at(std::size_t i) const;
  /// The rays with these numbers, in this order and precision.
  RaySet pick(std::span<const std::size_t> chosen) const;

  /// Calls use(RayColumns) with rows `first` up to `first + count`, in the set's precision.
  template <class Use>
  auto with(std::size_t first, std::size_t count, const Use& use) const {
    return std::visit([&](const auto& columns) { return use(columns.rows(first, count)); },
                      columns_);
  }

 private:
  template <class Scalar>
  struct Columns {
    std::vector<Scalar> origins, directions, tmin, tmax;  // the last two may be empty

    RayColumns<const Scalar> rows(std::size_t first, std::size_t count) const {
      const auto part = [&](const std::vector<Scalar>& all, std::size_t width) {
        return all.empty() ? std::span<const Scalar>()
                           : std::span(all).subspan(first * width, count * width);
      };
      return {part(origins, 3), part(directions, 3), part(tmin, 1), part(tmax, 1), {}};
    }
    void add(const Ray& ray, bool with_interval);
  };

  std::variant<Columns<float>, Columns<double>> columns_;
};

/// The batches into which a set is cut; request k casts batch k, and after the last comes the
/// first.
class Batches {
 public:
  /// `batch` > 0.
  Batches(const RaySet& rays, std::size_t batch) : rays_(&rays), batch_(batch) {}
  std::size_t count() const { return (rays_->size() + batch_ - 1) / batch_; }

  template <class Use>
  auto with(std::uint64_t request, const Use& use) const {
    const std::size_t first = static_cast<std::size_t>(request % count()) * batch_;
    const std::size_t left = rays_->size() - first;
    return rays_->with(first, left < batch_ ? left : batch_, use);
  }

 private:
  const RaySet* rays_;
  std::size_t batch_;
};

}  // namespace sightline::client::load

// Columns from rays, and rays from columns.
#include "client/load/ray_set.h"

#include <algorithm>

namespace sightline::client::load {
namespace {

bool has_interval(const Ray& ray) { return ray.tmin != Ray{}.tmin || ray.tmax != Ray{}.tmax; }

template <class T>
void append_to(std::vector<T>& all, std::span<const T> more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

template <class Scalar>
void RaySet::Columns<Scalar>::add(const Ray& ray, bool with_interval) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    origins.push_back(static_cast<Scalar>(ray.origin[axis]));
    directions.push_back(static_cast<Scalar>(ray.direction[axis]));
  }
  if (!with_interval) return;
  tmin.push_back(static_cast<Scalar>(ray.tmin));
  tmax.push_back(static_cast<Scalar>(ray.tmax));
}

RaySet RaySet::of(std::span<const Ray> rays, Precision precision) {
  RaySet set;
  if (precision == Precision::kDouble) set.columns_.emplace<Columns<double>>();
  const bool with_interval = std::any_of(rays.begin(), rays.end(), has_interval);
  std::visit(
      [&](auto& columns) {
        for (const Ray& ray : rays) columns.add(ray, with_interval);
      },
      set.columns_);
  return set;
}

template <class Scalar>
RaySet RaySet::copy(const RayColumns<const Scalar>& rays) {
  RaySet set;
  set.columns_.emplace<Columns<Scalar>>();
  set.append(rays);
  return set;
}
template RaySet RaySet::copy(const RayColumns<const float>&);
template RaySet RaySet::copy(const RayColumns<const double>&);

template <class Scalar>
void RaySet::append(const RayColumns<const Scalar>& rays) {
  auto& columns = std::get<Columns<Scalar>>(columns_);
  append_to(columns.origins, rays.origins);
  append_to(columns.directions, rays.directions);
  append_to(columns.tmin, rays.tmin);
  append_to(columns.tmax, rays.tmax);
}
template void RaySet::append(const RayColumns<const float>&);
template void RaySet::append(const RayColumns<const double>&);

std::size_t RaySet::size() const {
  return std::visit([](const auto& columns) { return columns.origins.size() / 3; }, columns_);
}

Ray RaySet::at(std::size_t i) const {
  return std::visit(
      [&](const auto& columns) {
        Ray ray;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ray.origin[axis] = static_cast<double>(columns.origins[3 * i + axis]);
          ray.direction[axis] = static_cast<double>(columns.directions[3 * i + axis]);
        }
        if (!columns.tmin.empty()) ray.tmin = static_cast<double>(columns.tmin[i]);
        if (!columns.tmax.empty()) ray.tmax = static_cast<double>(columns.tmax[i]);
        return ray;
      },
      columns_);
}

RaySet RaySet::pick(std::span<const std::size_t> chosen) const {
  return std::visit(
      [&]<class C>(const C& columns) {
        RaySet set;
        C& picked = set.columns_.template emplace<C>();
        for (const std::size_t i : chosen) picked.add(at(i), !columns.tmin.empty());
        return set;
      },
      columns_);
}

}  // namespace sightline::client::load

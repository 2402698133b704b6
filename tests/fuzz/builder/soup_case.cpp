// Corners are new points, or share coordinates of earlier ones.
#include "tests/fuzz/builder/soup_case.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "accel/published/any_builder.h"
#include "tests/fuzz/hostile_number.h"

namespace sightline::tests {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

Vec3f take_point(Bytes& bytes, const std::vector<Vec3f>& earlier) {
  if (earlier.empty()) {
    const float x = take_float(bytes), y = take_float(bytes);
    return {x, y, take_float(bytes)};
  }
  const auto kind = bytes.take<std::uint8_t>();
  Vec3f p = earlier[bytes.below(earlier.size())];
  const std::size_t axis = kind % 3;
  if (kind < 64) {
    p[axis] = take_float(bytes);
  } else if (kind < 96) {
    p[axis] = std::nextafter(p[axis], kind % 2 == 0 ? 1e38f : -1e38f);
  } else if (kind < 128) {
    p[axis] += static_cast<float>(bytes.take<std::int8_t>());
  } else if (kind < 192) {  // In its plane
    p[(axis + 1) % 3] = static_cast<float>(bytes.take<std::int8_t>());
    p[(axis + 2) % 3] = static_cast<float>(bytes.take<std::int8_t>());
  } else {
    for (std::size_t k = 0; k < 3; ++k) p[k] = take_float(bytes);
  }
  return p;
}

void take_faces(Bytes& bytes, SoupCase& soup) {
  for (std::size_t left = bytes.below(61); left > 0; --left) {
    const auto kind = bytes.take<std::uint8_t>();
    if (kind >= 250) {
      soup.faces.push_back(
          {accel::geometry::kNoVertex, accel::geometry::kNoVertex, accel::geometry::kNoVertex});
      continue;
    }
    if (kind >= 220 && !soup.faces.empty()) {
      soup.faces.push_back(soup.faces[bytes.below(soup.faces.size())]);
      continue;
    }
    accel::geometry::Face face{};
    for (std::uint32_t& corner : face) {
      const std::size_t choice = bytes.below(2 * soup.vertices.size() + 2);
      if (choice < soup.vertices.size()) {
        corner = static_cast<std::uint32_t>(choice);
        continue;
      }
      corner = static_cast<std::uint32_t>(soup.vertices.size());
      soup.vertices.push_back(take_point(bytes, soup.vertices));
    }
    soup.faces.push_back(face);
  }
}

/// The naive search takes quadratic time.
std::size_t most_faces(const SoupCase& soup) {
  return soup.builder == "sah-naive" ? kMostFaces / 4 : kMostFaces;
}

/// The list becomes long enough that cells are deferred and runs are made.
void copy_faces(Bytes& bytes, SoupCase& soup) {
  const auto kind = bytes.take<std::uint8_t>();
  if (kind < 192 || soup.faces.empty()) return;
  const bool moved = kind % 2 == 0;
  const Vec3f step = moved ? take_point(bytes, soup.vertices) : Vec3f{};
  const std::size_t faces = soup.faces.size(), vertices = soup.vertices.size();
  const std::size_t copies = std::min<std::size_t>(2 + kind % 32, most_faces(soup) / faces);
  for (std::size_t copy = 1; copy < copies; ++copy) {
    for (std::size_t v = 0; moved && v < vertices; ++v) {
      Vec3f p = soup.vertices[v];
      for (std::size_t k = 0; k < 3; ++k) p[k] += step[k] * static_cast<float>(copy);
      soup.vertices.push_back(p);
    }
    for (std::size_t f = 0; f < faces; ++f) {
      accel::geometry::Face face = soup.faces[f];
      for (std::uint32_t& corner : face) {
        if (moved && corner != accel::geometry::kNoVertex)
          corner += static_cast<std::uint32_t>(copy * vertices);
      }
      soup.faces.push_back(face);
    }
  }
}

void take_parameters(Bytes& bytes, SoupCase& soup) {
  static constexpr std::string_view kNames[] = {
      "leaf_size",       "max_depth",   "cost_traverse", "cost_intersect", "bins",
      "samples",         "exact_below", "hybrid_below",  "empty_bonus",    "retry_above",
      "refine_all_axes", "snap",        "clip",          "lambda",         "bad_refines",
      "subsample",       "threads",     "alpha",         "spatial_bins",   "unsplit",
      "budget",          "threshold"};
  static constexpr const char* kValues[] = {"0",   "1",    "2",     "3",    "4",   "8",
                                            "16",  "64",   "256",   "1000", "0.5", "0.001",
                                            "1e6", "1e-6", "1e300", "off",  "on",  "4294967295"};
  // If a step costs almost nothing, a few triangles give a tree as large as the capacity allows.
  static constexpr const char* kCosts[] = {"0.5", "1", "1.5", "4", "20", "1e6", "1e300", "nan"};
  for (std::size_t left = bytes.below(4); left > 0; --left) {
    const std::string_view name = kNames[bytes.below(std::size(kNames))];
    const char* const value = name.starts_with("cost_") ? kCosts[bytes.below(std::size(kCosts))]
                                                        : kValues[bytes.below(std::size(kValues))];
    soup.parameters.emplace_back(name, value);
  }
}

Vec3d take_vector(Bytes& bytes) {
  const double x = take_double(bytes), y = take_double(bytes);
  return {x, y, take_double(bytes)};
}

/// Through a corner, a point of an edge or of a face, along an edge or an axis, or anywhere.
Ray take_ray(Bytes& bytes, const SoupCase& soup) {
  const auto kind = bytes.take<std::uint8_t>();
  Ray ray;
  if (soup.faces.empty() || soup.vertices.empty() || kind >= 224)
    return {take_vector(bytes), take_vector(bytes)};
  accel::geometry::Face face = soup.faces[bytes.take<std::uint16_t>() % soup.faces.size()];
  if (face[0] == accel::geometry::kNoVertex) face = {};
  const Vec3d a(soup.vertices[face[0]]), b(soup.vertices[face[1]]), c(soup.vertices[face[2]]);
  const auto share = [&] { return static_cast<double>(bytes.below(9)) / 8; };
  const double along = share();
  const Vec3d target = a + (b - a) * along + (c - a) * (kind % 2 == 0 ? 0 : (1 - along) * share());
  if (kind < 96) {
    ray.origin = take_vector(bytes);
    ray.direction = target - ray.origin;
  } else if (kind < 160) {
    ray.direction[kind % 3] = kind % 4 < 2 ? 1 : -1;
    ray.origin = target - ray.direction * static_cast<double>(bytes.take<std::int8_t>());
  } else {  // In its plane
    ray.direction = kind % 3 == 0 ? b - a : c - a;
    ray.origin = target - ray.direction * static_cast<double>(bytes.below(3));
  }
  return ray;
}

void limit(Bytes& bytes, Ray& ray) {
  const auto kind = bytes.take<std::uint8_t>();
  if (kind < 192) return;
  ray.tmin = kind % 2 == 0 ? 1 : take_double(bytes);
  if (kind % 4 < 2) ray.tmax = kind % 8 == 0 ? 1 : take_double(bytes);
}

}  // namespace

SoupCase make_soup(Bytes bytes) {
  const std::vector<std::string_view> names = accel::published::builder_names();
  SoupCase soup;
  soup.builder = names[bytes.below(names.size())];
  const auto how = bytes.take<std::uint8_t>();
  soup.references = how % 2 == 0 ? accel::mesh::References::kRuns : accel::mesh::References::kSoup;
  soup.in_parallel = how / 2 % 8 == 0;
  soup.culling = static_cast<accel::geometry::Culling>(how / 16 % 3);
  take_parameters(bytes, soup);
  take_faces(bytes, soup);
  copy_faces(bytes, soup);
  for (std::size_t left = 1 + bytes.below(8); left > 0; --left) {
    soup.rays.push_back(take_ray(bytes, soup));
    limit(bytes, soup.rays.back());
  }
  return soup;
}

}  // namespace sightline::tests

// Copies rows of columns.
#include "client/calls/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>

namespace sightline::client::calls {
namespace {

struct Column {
  const char* name;
  std::size_t values;
  std::size_t width;
};

Status check_column(const Column& column, std::size_t count, const char* rows) {
  if (column.values == 0 || column.values == count * column.width) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("{} holds {} values, but {} {} need {}", column.name, column.values,
                           count, rows, count * column.width),
               {}};
}

Status check_bits(const char* name, std::size_t bytes, std::size_t count, const char* rows) {
  if (bytes == 0 || bytes == bits_bytes(count)) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("{} holds {} bytes, but {} {} need {}", name, bytes, count, rows,
                           bits_bytes(count)),
               {}};
}

template <class T>
void copy_rows(std::span<const T> from, std::size_t first, std::size_t width, std::span<T> to) {
  std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first * width), to.size(), to.begin());
}

// A bound that the caller left out is filled in: a message has both bounds or neither.
template <class T>
void copy_bound(std::span<const T> from, std::size_t first, T otherwise, std::span<T> to) {
  if (from.empty()) {
    std::fill(to.begin(), to.end(), otherwise);
  } else {
    copy_rows(from, first, 1, to);
  }
}

/// The first n rows of a buffer, with the columns that it has.
template <class Scalar>
RayColumns<Scalar> first_of(const RayColumns<Scalar>& buffer, std::size_t n) {
  RayColumns<Scalar> rows{buffer.origins.first(3 * n), buffer.directions.first(3 * n)};
  if (!buffer.tmin.empty()) rows.tmin = buffer.tmin.first(n);
  if (!buffer.tmax.empty()) rows.tmax = buffer.tmax.first(n);
  if (!buffer.masks.empty()) rows.masks = buffer.masks.first(n);
  return rows;
}

template <class Scalar>
PointColumns<Scalar> first_of(const PointColumns<Scalar>& buffer, std::size_t n) {
  PointColumns<Scalar> rows{buffer.positions.first(3 * n)};
  if (!buffer.max_distance.empty()) rows.max_distance = buffer.max_distance.first(n);
  if (!buffer.masks.empty()) rows.masks = buffer.masks.first(n);
  return rows;
}

template <class Buffer, class Columns>
RowSource<Buffer> part_after_part(const Columns& columns) {
  return [&columns, sent = std::size_t{0}](const Buffer& buffer) mutable -> Result<std::size_t> {
    const std::size_t n = std::min(buffer.size(), columns.size() - sent);
    copy_part(columns, sent, first_of(buffer, n));
    sent += n;
    return n;
  };
}

template <class T>
void put_rows(std::span<const T> from, std::size_t first, std::size_t width, std::span<T> to) {
  if (!to.empty()) {
    std::copy(from.begin(), from.end(), to.begin() + static_cast<std::ptrdiff_t>(first * width));
  }
}

}  // namespace

HitFields fields_of(const HitColumns& hits) {
  HitFields fields;
  fields.t = !hits.t.empty();
  fields.node = !hits.node.empty();
  fields.primitive = !hits.primitive.empty();
  fields.barycentric = !hits.barycentric.empty();
  fields.normal = !hits.normal.empty();
  fields.hit = !hits.hit.empty();
  fields.hit_bits = !hits.hit_bits.empty();
  fields.work = !hits.work.empty();
  fields.count = !hits.count.empty();
  fields.position = !hits.position.empty();
  fields.name = !hits.name.empty();
  fields.signed_distance = !hits.signed_distance.empty();
  fields.inside = !hits.inside.empty();
  fields.votes = !hits.votes.empty();
  return fields;
}

Status check_kind(QueryKind kind) {
  if (kind != QueryKind::kAll) return {};
  return Error{
      Code::kInvalidArgument,
      "all answers to a ray or a point do not fit a row: use cast_all or nearest_all, or a sink",
      {}};
}

Status check_rows(std::size_t n, const HitColumns& hits, const char* rows) {
  for (const Column& column :
       {Column{"t", hits.t.size(), 1}, Column{"node", hits.node.size(), 1},
        Column{"primitive", hits.primitive.size(), 1},
        Column{"barycentric", hits.barycentric.size(), 2}, Column{"normal", hits.normal.size(), 3},
        Column{"hit", hits.hit.size(), 1}, Column{"work", hits.work.size(), 1},
        Column{"count", hits.count.size(), 1}, Column{"position", hits.position.size(), 3},
        Column{"name", hits.name.size(), 1},
        Column{"signed_distance", hits.signed_distance.size(), 1},
        Column{"inside", hits.inside.size(), 1}, Column{"votes", hits.votes.size(), 1}}) {
    if (Status checked = check_column(column, n, rows); !checked) return checked;
  }
  if (Status checked = check_bits("hit_bits", hits.hit_bits.size(), n, rows); !checked)
    return checked;
  return check_bits("unanswered", hits.unanswered.size(), n, rows);
}

template <class Scalar>
Status check_rows(const RayColumns<const Scalar>& rays, const HitColumns& hits) {
  const std::size_t n = rays.size();
  if (rays.origins.size() != 3 * n || rays.directions.size() != 3 * n) {
    return Error{Code::kInvalidArgument,
                 fmt::format("origins hold {} values and directions {}: not 3 a ray",
                             rays.origins.size(), rays.directions.size()),
                 {}};
  }
  for (const Column& column :
       {Column{"tmin", rays.tmin.size(), 1}, Column{"tmax", rays.tmax.size(), 1},
        Column{"masks", rays.masks.size(), 1}}) {
    if (Status checked = check_column(column, n, "rays"); !checked) return checked;
  }
  return check_rows(n, hits);
}

template <class Scalar>
Status check_rows(const PointColumns<const Scalar>& points, const HitColumns& hits) {
  constexpr const char* kRows = "points";
  const std::size_t n = points.size();
  if (points.positions.size() != 3 * n) {
    return Error{Code::kInvalidArgument,
                 fmt::format("positions hold {} values: not 3 a point", points.positions.size()),
                 {}};
  }
  for (const Column& column : {Column{"max_distance", points.max_distance.size(), 1},
                               Column{"masks", points.masks.size(), 1}}) {
    if (Status checked = check_column(column, n, kRows); !checked) return checked;
  }
  return check_rows(n, hits, kRows);
}

template <class Scalar>
void copy_part(const RayColumns<const Scalar>& rays, std::size_t first,
               const RayColumns<Scalar>& buffer) {
  copy_rows(rays.origins, first, 3, buffer.origins);
  copy_rows(rays.directions, first, 3, buffer.directions);
  copy_bound(rays.tmin, first, Scalar{0}, buffer.tmin);
  copy_bound(rays.tmax, first, std::numeric_limits<Scalar>::infinity(), buffer.tmax);
  if (!buffer.masks.empty()) copy_rows(rays.masks, first, 1, buffer.masks);
}

template <class Scalar>
void copy_part(const PointColumns<const Scalar>& points, std::size_t first,
               const PointColumns<Scalar>& buffer) {
  copy_rows(points.positions, first, 3, buffer.positions);
  if (!buffer.max_distance.empty()) copy_rows(points.max_distance, first, 1, buffer.max_distance);
  if (!buffer.masks.empty()) copy_rows(points.masks, first, 1, buffer.masks);
}

template <class Scalar>
RaySource<Scalar> source_of(const RayColumns<const Scalar>& rays) {
  return part_after_part<RayColumns<Scalar>>(rays);
}

template <class Scalar>
PointSource<Scalar> source_of(const PointColumns<const Scalar>& points) {
  return part_after_part<PointColumns<Scalar>>(points);
}

void copy_hits(const HitView& answers, std::size_t first, const HitColumns& hits) {
  put_rows(answers.t, first, 1, hits.t);
  put_rows(answers.node, first, 1, hits.node);
  put_rows(answers.primitive, first, 1, hits.primitive);
  put_rows(answers.barycentric, first, 2, hits.barycentric);
  put_rows(answers.normal, first, 3, hits.normal);
  put_rows(answers.hit, first, 1, hits.hit);
  put_rows(answers.hit_bits, bits_bytes(first), 1, hits.hit_bits);
  put_rows(answers.unanswered, bits_bytes(first), 1, hits.unanswered);
  put_rows(answers.work, first, 1, hits.work);
  put_rows(answers.count, first, 1, hits.count);
  put_rows(answers.position, first, 3, hits.position);
  put_rows(answers.signed_distance, first, 1, hits.signed_distance);
  put_rows(answers.inside, first, 1, hits.inside);
  put_rows(answers.votes, first, 1, hits.votes);
  if (hits.name.empty()) return;
  for (std::size_t i = 0; i < answers.name.size(); ++i)
    hits.name[first + i] = answers.names[answers.name[i]];
}

HitSink copy_to(const HitColumns& hits) {
  std::fill(hits.unanswered.begin(), hits.unanswered.end(), std::uint8_t{0});
  return [&hits](std::uint64_t first, std::size_t, const HitView& answers) {
    copy_hits(answers, first, hits);
    return Status();
  };
}

template Status check_rows(const RayColumns<const float>&, const HitColumns&);
template Status check_rows(const RayColumns<const double>&, const HitColumns&);
template Status check_rows(const PointColumns<const float>&, const HitColumns&);
template Status check_rows(const PointColumns<const double>&, const HitColumns&);
template void copy_part(const RayColumns<const float>&, std::size_t, const RayColumns<float>&);
template void copy_part(const RayColumns<const double>&, std::size_t, const RayColumns<double>&);
template void copy_part(const PointColumns<const float>&, std::size_t, const PointColumns<float>&);
template void copy_part(const PointColumns<const double>&, std::size_t,
                        const PointColumns<double>&);
template RaySource<float> source_of(const RayColumns<const float>&);
template RaySource<double> source_of(const RayColumns<const double>&);
template PointSource<float> source_of(const PointColumns<const float>&);
template PointSource<double> source_of(const PointColumns<const double>&);

}  // namespace sightline::client::calls

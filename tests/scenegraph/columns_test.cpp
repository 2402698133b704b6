// Rays and hits in columns: the answers are those of arrays of structs, bit for bit.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::RayColumns;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

std::shared_ptr<const revision::Snapshot> scene_of(int instances) {
  Scene scene;
  const auto mesh = tests::mesh_of(tests::icosphere(4));
  std::vector<model::Update> updates;
  for (int i = 0; i < instances; ++i) {
    model::Affine where;
    where.m[3] = 1.5 * i;
    model::PutNode node = tests::put_node(-1 - i, 0, mesh);
    node.parent_from_local = where;
    node.mask = 1u << i % 2;
    updates.push_back(node);
  }
  EXPECT_TRUE(scene.apply(updates));
  return scene.snapshot();
}

enum class Rays { kFromOnePoint, kScattered };

/// Numbers that floats hold. Some rays are invalid, some see half of the nodes.
std::vector<Ray> make_rays(Rays kind, std::size_t count) {
  tests::Random random(3);
  const auto number = [&] { return static_cast<double>(random.below(65536)) / 16384 - 2; };
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    Ray& ray = rays[i];
    ray.origin = kind == Rays::kFromOnePoint ? Vec3d{0, 0, 5} : Vec3d{number(), number(), 5};
    ray.direction = Vec3d{number() / 4, number() / 4, -1};
    if (kind == Rays::kFromOnePoint && i < count / 2) continue;
    if (i % 7 == 0) ray.mask = 1;
    if (i % 11 == 0) ray.tmin = 4.5;
    if (i % 13 == 0) ray.tmax = 4.5;
    if (i % 31 == 0) ray.direction = {};
    if (i % 37 == 0) ray.tmin = std::nan("");
    if (i % 41 == 0) ray.origin.x = 0x1p+100;  // beyond the range of floats, which packets use
  }
  return rays;
}

/// The columns of a message: three numbers a row; bytes that begin anywhere.
class PackedRays {
 public:
  PackedRays(const std::vector<Ray>& rays, bool float64, std::size_t misaligned)
      : misaligned_(misaligned) {
    const std::size_t element = float64 ? sizeof(double) : sizeof(float), n = rays.size();
    for (std::vector<std::byte>* vector : {&origins_, &directions_})
      vector->resize(misaligned + 3 * n * element);
    for (std::vector<std::byte>* column : {&tmin_, &tmax_})
      column->resize(misaligned + n * element);
    masks_.resize(misaligned + n * sizeof(std::uint32_t));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        put(origins_, 3 * i + axis, rays[i].origin[axis], float64);
        put(directions_, 3 * i + axis, rays[i].direction[axis], float64);
      }
      put(tmin_, i, rays[i].tmin, float64);
      put(tmax_, i, rays[i].tmax, float64);
      std::memcpy(masks_.data() + misaligned + 4 * i, &rays[i].mask, 4);
    }
    columns_ = {.size = n,
                .origin = accel::geometry::columns_of_rows(at(origins_), float64),
                .direction = accel::geometry::columns_of_rows(at(directions_), float64),
                .tmin = {at(tmin_), 1, float64},
                .tmax = {at(tmax_), 1, float64},
                .mask = {at(masks_), 1}};
  }
  const RayColumns& columns() const { return columns_; }

 private:
  const std::byte* at(const std::vector<std::byte>& column) const {
    return column.data() + misaligned_;
  }
  void put(std::vector<std::byte>& column, std::size_t index, double number, bool float64) const {
    std::byte* const to = column.data() + misaligned_;
    const auto narrow = static_cast<float>(number);
    if (float64) {
      std::memcpy(to + index * sizeof(number), &number, sizeof(number));
    } else {
      std::memcpy(to + index * sizeof(narrow), &narrow, sizeof(narrow));
    }
  }
  std::size_t misaligned_;
  std::vector<std::byte> origins_, directions_, tmin_, tmax_, masks_;
  RayColumns columns_;
};

/// A column of exactly `count` values, filled with what no answer is.
template <class T>
struct PackedField {
  PackedField(std::size_t count, std::size_t before)
      : bytes(before + count * sizeof(T), std::byte{0xa5}), misaligned(before) {}
  accel::geometry::FieldColumn<T> column() { return {bytes.data() + misaligned}; }
  T operator[](std::size_t i) const {
    T value;
    std::memcpy(&value, bytes.data() + misaligned + i * sizeof(T), sizeof(T));
    return value;
  }
  std::vector<std::byte> bytes;
  std::size_t misaligned;
};

/// All fields, each in memory of its own.
struct PackedHits {
  PackedHits(std::size_t count, std::size_t misaligned)
      : t(count, misaligned),
        node(count, misaligned),
        primitive(count, misaligned),
        barycentric(count, misaligned),
        normal(count, misaligned),
        work(count, misaligned),
        state(count, misaligned),
        bits((count + 7) / 8, 0xff) {
    columns.size = count;
    columns.t = t.column();
    columns.node = node.column();
    columns.primitive = primitive.column();
    columns.barycentric = barycentric.column();
    columns.normal = normal.column();
    columns.work = work.column();
    columns.state = state.column();
    columns.bits = bits.data();
  }
  PackedField<double> t;
  PackedField<std::uint64_t> node;
  PackedField<std::uint32_t> primitive;
  PackedField<std::array<float, 2>> barycentric;
  PackedField<Vec3f> normal;
  PackedField<std::uint32_t> work;
  PackedField<HitState> state;
  std::vector<std::uint8_t> bits;
  HitColumns columns;
};

bool same_bits(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) ||
         std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void expect_equal(const PackedHits& packed, const std::vector<Hit>& hits) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    SCOPED_TRACE(i);
    const Hit& hit = hits[i];
    ASSERT_TRUE(same_bits(packed.t[i], hit.t)) << packed.t[i] << " is not " << hit.t;
    ASSERT_EQ(packed.node[i], hit.node);
    ASSERT_EQ(packed.primitive[i], hit.primitive);
    ASSERT_EQ(packed.barycentric[i], (std::array<float, 2>{hit.u, hit.v}));
    ASSERT_EQ(packed.normal[i], hit.normal);
    ASSERT_EQ(packed.work[i], hit.work);
    ASSERT_EQ(packed.state[i], hit.state);
    ASSERT_EQ(packed.bits[i / 8] >> i % 8 & 1, hit.state == HitState::kHit ? 1 : 0);
  }
  for (std::size_t i = hits.size(); i < 8 * packed.bits.size(); ++i)
    ASSERT_EQ(packed.bits[i / 8] >> i % 8 & 1, 0);
}

TEST(ColumnsTest, AnswersAreThoseOfArrays) {
  constexpr std::size_t kCounts[] = {1, 100, 2 * kRaysPerBlock, 2 * kRaysPerBlock + 13};
  for (const int instances : {1, 5}) {
    const auto snapshot = scene_of(instances);
    ASSERT_TRUE(build_all(*snapshot));  // so that the work is the same
    for (const Rays kind : {Rays::kFromOnePoint, Rays::kScattered}) {
      for (const std::size_t count : kCounts) {
        const std::vector<Ray> rays = make_rays(kind, count);
        for (const QueryKind asked : {QueryKind::kClosest, QueryKind::kAny}) {
          std::vector<Hit> hits(count);
          const auto expected = trace(*snapshot, rays, hits, {.kind = asked});
          ASSERT_TRUE(expected);
          for (const bool float64 : {false, true}) {
            for (const std::size_t misaligned : {0u, 1u}) {
              SCOPED_TRACE(testing::Message() << instances << " instances, " << count << " rays, "
                                              << float64 << ' ' << misaligned);
              const PackedRays packed(rays, float64, misaligned);
              PackedHits answers(count, misaligned);
              const auto traced =
                  trace(*snapshot, packed.columns(), answers.columns, {.kind = asked});
              ASSERT_TRUE(traced);
              EXPECT_EQ(traced->hits, expected->hits);
              EXPECT_EQ(traced->invalid, expected->invalid);
              ASSERT_NO_FATAL_FAILURE(expect_equal(answers, hits));
            }
          }
        }
      }
    }
  }
}

TEST(ColumnsTest, TheRaysMeetEveryKindOfAnswer) {
  const auto snapshot = scene_of(5);
  const std::vector<Ray> rays = make_rays(Rays::kScattered, 1000);
  std::vector<Hit> hits(rays.size());
  const auto traced = trace(*snapshot, rays, hits, {});
  ASSERT_TRUE(traced);
  EXPECT_GT(traced->hits, 100u);
  EXPECT_GT(traced->invalid, 10u);
  EXPECT_LT(traced->hits + traced->invalid, rays.size() - 100);
}

TEST(ColumnsTest, OnlyAskedFieldsAreWritten) {
  const auto snapshot = scene_of(1);
  const std::vector<Ray> rays = make_rays(Rays::kScattered, 600);
  std::vector<Hit> hits(rays.size());
  ASSERT_TRUE(trace(*snapshot, rays, hits, {}));
  PackedHits normals(rays.size(), 0);
  const auto columns = columns_of(rays);
  HitColumns asked;
  asked.size = rays.size();
  ASSERT_TRUE(trace(*snapshot, columns, asked, {}));
  asked.normal = normals.normal.column();
  ASSERT_TRUE(trace(*snapshot, columns, asked, {}));
  PackedHits bits(rays.size(), 0);
  asked.normal = {};
  asked.bits = bits.bits.data();
  ASSERT_TRUE(trace(*snapshot, columns, asked, {.kind = QueryKind::kAny}));
  const PackedHits nothing(rays.size(), 0);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(normals.normal[i], hits[i].normal);
    ASSERT_EQ(bits.bits[i / 8] >> i % 8 & 1, hits[i].state == HitState::kHit ? 1 : 0);
  }
  EXPECT_EQ(normals.t.bytes, nothing.t.bytes);
  EXPECT_EQ(bits.state.bytes, nothing.state.bytes);
}

TEST(ColumnsTest, OneNumberMayStandForAllRays) {
  const auto snapshot = scene_of(3);
  std::vector<Ray> rays = make_rays(Rays::kFromOnePoint, 700);
  for (Ray& ray : rays) {
    ray.tmin = 0.5;
    ray.tmax = 4.5;
    ray.mask = 2;
    ray.origin = rays[0].origin;
  }
  std::vector<Hit> hits(rays.size());
  ASSERT_TRUE(trace(*snapshot, rays, hits, {}));
  RayColumns columns = columns_of(rays);
  for (std::size_t axis = 0; axis < 3; ++axis) columns.origin[axis].stride = 0;
  columns.tmin.stride = columns.tmax.stride = 0;
  columns.mask.stride = 0;
  PackedHits answers(rays.size(), 0);
  ASSERT_TRUE(trace(*snapshot, columns, answers.columns, {}));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(same_bits(answers.t[i], hits[i].t));
    ASSERT_EQ(answers.primitive[i], hits[i].primitive);
  }
}

TEST(ColumnsTest, RaysAreCountedInColumns) {
  const auto snapshot = scene_of(5);
  const std::vector<Ray> rays = make_rays(Rays::kScattered, 600);
  std::vector<RayTally> expected(rays.size()), tallies(rays.size());
  ASSERT_TRUE(count_hits(*snapshot, rays, expected, {}));
  const PackedRays packed(rays, false, 1);
  ASSERT_TRUE(count_hits(*snapshot, packed.columns(), tallies, {}));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(tallies[i].count, expected[i].count);
    ASSERT_EQ(tallies[i].state, expected[i].state);
  }
}

TEST(ColumnsTest, SizesMustAgree) {
  const auto snapshot = scene_of(1);
  const std::vector<Ray> rays = make_rays(Rays::kScattered, 10);
  PackedHits answers(9, 0);
  const auto traced = trace(*snapshot, columns_of(rays), answers.columns, {});
  ASSERT_FALSE(traced);
  EXPECT_EQ(traced.error().reason, "COUNT_MISMATCH");
}

TEST(ColumnsTest, NoRaysAreNoError) {
  const auto snapshot = scene_of(1);
  EXPECT_TRUE(trace(*snapshot, RayColumns{}, HitColumns{}, {}));
}

}  // namespace
}  // namespace sightline::scenegraph

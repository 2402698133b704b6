// Backups: what is read from one server is restored in another, whole, at any revision that it has.
#include "server/durable/restorer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "server/durable/backup_reader.h"
#include "tests/server/durable/life.h"

namespace sightline::server::durable {
namespace {

using scenegraph::model::PatchVertices;
using scenegraph::model::SetTransforms;
using Parts = std::vector<v1::BackupPart>;

scenegraph::model::Affine at(double x) { return {{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}; }

class RestorerTest : public tests::DurableTest {
 protected:
  Parts back_up(const std::string& only = {}, const std::set<blobs::BlobDigest>& known = {}) {
    BackupReader reader(*life_->store, only, known);
    EXPECT_TRUE(reader.begin());
    Parts parts;
    for (v1::BackupPart part;;) {
      const auto more = reader.next(part);
      EXPECT_TRUE(more) << more.error().message;
      if (!more || !*more) return parts;
      parts.push_back(part);
    }
  }
  Status restore(const Parts& parts, Restorer::Wanted wanted = {}) {
    Restorer restorer({life_->scenes, life_->blobs, life_->memory, {"admin", "admin:1"}},
                      std::move(wanted));
    for (const v1::BackupPart& part : parts) {
      if (Status taken = restorer.take(part); !taken) return taken;
    }
    return restorer.finish();
  }
  /// Loses the directory.
  void lose_all() {
    life_.reset();
    std::filesystem::remove_all(root_ / "data");
    life_.emplace(root_ / "data");
  }
  /// Revision r moves the node to x = r.
  void make_revisions(std::uint64_t revisions) {
    ASSERT_TRUE(life_->scenes.create({.name = kName, .meters_per_unit = 2}));
    apply({put(add_mesh(tests::cube()))});
    for (std::uint64_t r = 2; r <= revisions; ++r)
      apply({SetTransforms{{1}, {at(static_cast<double>(r))}}});
  }
  double x() { return scene()->snapshot()->find(1)->parent_from_local.m[3]; }
};

TEST_F(RestorerTest, MeshesThatTheClientHasComeWithoutData) {
  make_revisions(2);
  apply({put(add_mesh(tests::icosphere(1)))});
  const Parts all = back_up();
  std::set<blobs::BlobDigest> known;
  for (const v1::BackupPart& part : all) {
    if (part.has_mesh() && known.empty())
      known.insert(*blobs::BlobDigest::parse(part.mesh().digest()));
  }
  Parts some = back_up({}, known);
  ASSERT_EQ(some.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool left_out = all[i].has_mesh() && all[i].mesh().digest() == known.begin()->text();
    if (left_out) {
      EXPECT_EQ(some[i].mesh().digest(), all[i].mesh().digest());
      EXPECT_EQ(some[i].mesh().data(), "");
      EXPECT_FALSE(some[i].mesh().more());
    } else {
      EXPECT_EQ(some[i].SerializeAsString(), all[i].SerializeAsString());
    }
  }
  lose_all();
  EXPECT_FALSE(restore(some)) << "a server that lacks the mesh does not take its name for it";
  EXPECT_TRUE(restore(all));
}

TEST_F(RestorerTest, ALostDirectoryIsRestored) {
  make_revisions(5);
  apply({put(add_mesh(tests::icosphere(1))), PatchVertices{{2}, 0, {{9, 9, 9}}}});
  const std::string token = scene()->token(6).text();
  const Parts parts = back_up();
  lose_all();
  ASSERT_TRUE(restore(parts));
  for (int life = 0; life < 2; ++life, restart()) {
    const auto restored = scene();
    EXPECT_EQ(restored->info().meters_per_unit, 2);
    EXPECT_EQ(restored->snapshot()->revision(), 6u);
    EXPECT_NE(restored->token(6).text(), token) << "it is another scene";
    EXPECT_EQ(x(), 5);
    EXPECT_EQ(restored->snapshot()->find(2)->mesh->view().vertices[0],
              (accel::geometry::Vec3f{9, 9, 9}));
  }
  apply({put(add_mesh(tests::cube()))});
  EXPECT_EQ(scene()->snapshot()->revision(), 7u);
  EXPECT_NE(scene()->snapshot()->find(3), nullptr) << "ids go on";
  EXPECT_FALSE(back_up().empty());
}

TEST_F(RestorerTest, AnEarlierRevisionReplacesTheScene) {
  make_revisions(5);
  const auto before = scene();
  const Parts parts = back_up(kName);
  for (const std::uint64_t revision : {3, 1, 0, 5}) {
    ASSERT_TRUE(restore(parts, {.revision = revision}));
    const std::uint64_t expected = revision == 0 ? 5 : revision;
    EXPECT_EQ(scene()->snapshot()->revision(), expected);
    EXPECT_EQ(x(), expected == 1 ? 0.0 : static_cast<double>(expected));
  }
  EXPECT_TRUE(before->removed());
  EXPECT_EQ(before->snapshot()->revision(), 5u) << "who has it may read it";
  const Status beyond = restore(parts, {.revision = 6});
  EXPECT_EQ(beyond.error().code, Code::kOutOfRange);
  EXPECT_EQ(scene()->snapshot()->revision(), 5u);
  EXPECT_EQ(restore(parts, {.scene = "projects/p/scenes/other"}).error().code, Code::kNotFound);
}

/// The log before a snapshot is gone; meshes are longer than a part.
TEST_F(RestorerTest, BeginsAtTheBase) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  apply({put(add_mesh(tests::planar_sheet(250)))});
  for (int i = 0; i < 300; ++i) {
    const auto z = static_cast<float>(i);
    apply({PatchVertices{{1}, 0, std::vector<accel::geometry::Vec3f>(3000, {0, 0, z})}});
  }
  restart();
  const std::uint64_t base = life_->store->scenes()->front().base;
  ASSERT_GT(base, 0u);
  const Parts parts = back_up();
  lose_all();
  EXPECT_EQ(restore(parts, {.revision = base - 1}).error().code, Code::kOutOfRange);
  for (const std::uint64_t revision : {base, base + 1, std::uint64_t{301}}) {
    ASSERT_TRUE(restore(parts, {.revision = revision}));
    EXPECT_EQ(scene()->snapshot()->find(1)->mesh->view().vertices[7],
              (accel::geometry::Vec3f{0, 0, static_cast<float>(revision - 2)}));
  }
}

TEST_F(RestorerTest, RefusesWhatIsNotWhole) {
  make_revisions(4);
  const Parts parts = back_up();
  lose_all();
  for (std::size_t missing = 0; missing < parts.size(); ++missing) {
    Parts some = parts;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(missing));
    EXPECT_FALSE(restore(some)) << "without part " << missing;
    if (missing > 0) {  // without its mesh, which is then stored
      EXPECT_FALSE(life_->scenes.get(kName));
    }
  }
  for (std::size_t length = 1; length < parts.size(); ++length)
    EXPECT_FALSE(restore({parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(length)}));
  Parts corrupt = parts;
  for (v1::BackupPart& part : corrupt) {
    if (part.has_batch()) part.mutable_batch()->set_updates("\xff");
  }
  EXPECT_EQ(restore(corrupt).error().code, Code::kDataLoss);
  EXPECT_TRUE(restore(parts));
}

TEST_F(RestorerTest, ASceneThatBeginsAgainIsRestoredOnce) {
  make_revisions(3);
  const Parts parts = back_up();
  Parts twice(parts.begin(), parts.end() - 2);
  for (const v1::BackupPart& part : parts) {
    if (!part.has_mesh()) twice.push_back(part);
  }
  lose_all();
  ASSERT_TRUE(restore(twice));
  EXPECT_EQ(x(), 3);
}

/// What arrives counts while it arrives; nothing is half applied.
TEST_F(RestorerTest, ABatchThatDoesNotEndIsRefusedWithTheLimit) {
  make_revisions(3);
  Parts parts = back_up();
  const auto batch = std::ranges::find_if(parts, [](const auto& part) { return part.has_batch(); });
  v1::BackupPart endless = *batch;
  endless.mutable_batch()->set_more(true);
  endless.mutable_batch()->set_updates(std::string(std::size_t{1} << 20, 'x'));
  const std::uint64_t before = life_->memory.used();
  const auto filler = life_->memory.record(
      exec::Held::kNodes, (std::uint64_t{1} << 30) - before - (std::uint64_t{16} << 20));
  {
    Restorer restorer({life_->scenes, life_->blobs, life_->memory, {"admin", "admin:1"}}, {});
    for (auto part = parts.begin(); part != batch; ++part) ASSERT_TRUE(restorer.take(*part));
    Status taken;
    int megabytes = 0;
    for (; taken && megabytes < 100; ++megabytes) {
      taken = restorer.take(endless);
      if (taken) {
        EXPECT_GE(life_->memory.used(exec::Held::kUploads), static_cast<std::uint64_t>(megabytes)
                                                                << 20);
      }
    }
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().reason, exec::kMemoryBudget) << taken.error().message;
    EXPECT_LT(megabytes, 20);
  }
  EXPECT_EQ(life_->memory.used(exec::Held::kUploads), 0u);
  EXPECT_EQ(scene()->snapshot()->revision(), 3u) << "the scene is as it was";
}

TEST_F(RestorerTest, WithoutRevisions) {
  ASSERT_TRUE(life_->scenes.create({.name = kName}));
  const Parts parts = back_up();
  lose_all();
  ASSERT_TRUE(restore(parts));
  restart();
  EXPECT_EQ(scene()->snapshot()->revision(), 0u);
  apply({put(add_mesh(tests::cube()))});
  EXPECT_EQ(scene()->snapshot()->revision(), 1u);
}

}  // namespace
}  // namespace sightline::server::durable

// Scenes survive the way between two processes, and broken ones are found.
#include "client/importer/check_received.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "client/importer/archive.h"
#include "client/importer/scene_fields.h"

namespace sightline::client::importer {
namespace {

/// One triangle with a skin of one bone, a shape, and an animation of both.
AnimatedScene small_scene() {
  AnimatedScene out;
  const ImportedMesh mesh{"mesh", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, 1, 0};
  out.scene.meshes.push_back(mesh);
  out.scene.nodes.push_back({.name = "root"});
  out.scene.nodes.push_back({.name = "child", .parent = 0, .mesh = 0});
  out.scene.meters_per_unit = 1;
  out.scene.warnings = {{"cut_off", 2, "mesh 'a'", "a warning"}};
  out.rig.parent_from_local = {kIdentity, kIdentity};
  out.rig.vertices.push_back({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  out.rig.offsets.emplace_back();
  out.rig.skins.push_back({{{1, kIdentity}}, {0, 1, 1, 1}, {{0, 1.0}}});
  out.rig.shapes.push_back({{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}});
  out.rig.weights.push_back({0.25});
  Animation animation;
  animation.name = "walk";
  animation.seconds = 2;
  NodeChannel channel;
  channel.node = 1;
  channel.positions.keys = {{0, {0, 0, 0}}, {1, {1, 0, 0}}};
  channel.rotations.keys = {{0, {1, 0, 0, 0}}};
  channel.scalings.keys = {{0, {1, 1, 1}}};
  animation.channels.push_back(channel);
  Deformation deformation{1, 0, {}};
  deformation.weights.keys = {{0, {0.5}}, {1, {}}};
  animation.deformations.push_back(deformation);
  out.animations.push_back(animation);
  return out;
}

struct Bytes {
  void write(const void* from, std::size_t count) {
    const auto* const first = static_cast<const std::byte*>(from);
    all.insert(all.end(), first, first + count);
  }
  std::vector<std::byte> all;
};

std::vector<std::byte> bytes_of(AnimatedScene scene) {
  Bytes bytes;
  ArchiveWriter writer(bytes);
  writer(scene);
  return bytes.all;
}

TEST(Archive, AReadSceneIsTheWrittenOne) {
  const std::vector<std::byte> bytes = bytes_of(small_scene());
  AnimatedScene read;
  ArchiveReader reader(bytes);
  reader(read);
  EXPECT_TRUE(reader.is_complete());
  EXPECT_EQ(bytes_of(read), bytes);
  EXPECT_EQ(read.scene.nodes[1].name, "child");
  EXPECT_EQ(read.animations[0].deformations[0].weights.keys[0].value, std::vector<double>{0.5});
  EXPECT_TRUE(check_received(read));
}

TEST(Archive, EveryCutIsFound) {
  const std::vector<std::byte> bytes = bytes_of(small_scene());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    AnimatedScene read;
    ArchiveReader reader(std::span<const std::byte>(bytes).first(size));
    reader(read);
    EXPECT_FALSE(reader.is_complete()) << size;
  }
}

// Whatever the bytes are, reading and checking ends, within the memory that they take.
TEST(Archive, AnyBytesCanBeRead) {
  const std::vector<std::byte> bytes = bytes_of(small_scene());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const unsigned value : {0x00U, 0x7FU, 0xFFU}) {
      std::vector<std::byte> changed = bytes;
      changed[i] = static_cast<std::byte>(value);
      AnimatedScene read;
      ArchiveReader reader(changed);
      reader(read);
      if (reader.is_complete()) (void)check_received(read).ok();
    }
  }
}

TEST(CheckReceived, FindsEveryBrokenGuarantee) {
  const std::vector<std::function<void(AnimatedScene&)>> faults{
      [](AnimatedScene& s) { s.scene.meshes[0].faces[0][1] = 3; },
      [](AnimatedScene& s) { s.scene.meshes[0].faces[0][1] = kNoVertex; },
      [](AnimatedScene& s) { s.scene.meshes[0].triangles = 2; },
      [](AnimatedScene& s) { s.scene.meshes[0].lines_and_points = 1; },
      [](AnimatedScene& s) { s.scene.meshes[0].name = "\xff"; },
      [](AnimatedScene& s) { s.scene.nodes[1].parent = 1; },
      [](AnimatedScene& s) { s.scene.nodes[1].mesh = 1; },
      [](AnimatedScene& s) { s.scene.nodes[0].name = std::string(2000, 'x'); },
      [](AnimatedScene& s) { s.scene.nodes[0].parent_from_local[3] = NAN; },
      [](AnimatedScene& s) { s.scene.nodes.clear(); },
      [](AnimatedScene& s) { s.scene.up_axis = static_cast<UpAxis>(7); },
      [](AnimatedScene& s) { s.scene.meters_per_unit = INFINITY; },
      [](AnimatedScene& s) { s.rig.parent_from_local.pop_back(); },
      [](AnimatedScene& s) { s.rig.skins.clear(); },
      [](AnimatedScene& s) { s.rig.vertices.clear(); },
      [](AnimatedScene& s) { s.rig.vertices[0].clear(); },
      [](AnimatedScene& s) { s.rig.shapes[0][0].pop_back(); },
      [](AnimatedScene& s) { s.rig.skins[0].bones[0].node = 2; },
      [](AnimatedScene& s) {
        s.rig.skins[0].first = {0, 2, 1, 1};
      },
      [](AnimatedScene& s) { s.rig.skins[0].influences[0].bone = 1; },
      [](AnimatedScene& s) { s.rig.offsets[0][0] = NAN; },
      [](AnimatedScene& s) { s.animations[0].seconds = -1; },
      [](AnimatedScene& s) { s.animations[0].channels[0].node = 9; },
      [](AnimatedScene& s) { s.animations[0].channels[0].scalings.keys.clear(); },
      [](AnimatedScene& s) { s.animations[0].channels[0].positions.keys[1].seconds = -1; },
      [](AnimatedScene& s) {
        s.animations[0].channels[0].rotations.after = static_cast<Beyond>(9);
      },
      [](AnimatedScene& s) { s.animations[0].deformations[0].mesh = kNone; },
      [](AnimatedScene& s) {
        s.animations[0].deformations[0].weights.keys[0].value = {1, 2};
      }};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    AnimatedScene scene = small_scene();
    faults[i](scene);
    EXPECT_FALSE(check_received(scene)) << i;
  }
}

}  // namespace
}  // namespace sightline::client::importer

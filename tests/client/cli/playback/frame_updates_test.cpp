// Poses as updates: only what is new.
#include "client/cli/playback/frame_updates.h"

#include <gtest/gtest.h>

#include <variant>

namespace sightline::client::cli::playback {
namespace {

Transform moved_by(double x) {
  Transform out = kIdentity;
  out[3] = x;
  return out;
}

TEST(FrameUpdates, SayOnlyWhatIsNew) {
  FrameUpdates frames({10, 11, 12, 13});
  importer::Pose pose;
  pose.placed = {{0, moved_by(1)}, {1, moved_by(2)}};
  pose.shaped = {{{2, 3}, {{0, 0, 1}}}};
  std::vector<Update> updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 2U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, (std::vector<NodeRef>{10, 11}));
  EXPECT_EQ(std::get<PatchVertices>(updates[1]).nodes, (std::vector<NodeRef>{12, 13}));
  EXPECT_TRUE(frames.make(pose).empty());

  pose.placed[1].parent_from_local = moved_by(3);
  updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 1U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, std::vector<NodeRef>{11});

  pose.shaped[0].vertices[0][2] = 2;
  updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 1U);
  EXPECT_EQ(std::get<PatchVertices>(updates[0]).positions, (std::vector<Vertex>{{0, 0, 2}}));

  frames.forget();
  EXPECT_EQ(frames.make(pose).size(), 2U);
}

TEST(FrameUpdates, NodesWithoutAnIdAreLeftAlone) {
  FrameUpdates frames({0, 11, 0, 13});
  importer::Pose pose;
  pose.placed = {{0, moved_by(1)}, {1, moved_by(2)}};
  pose.shaped = {{{2, 3}, {{0, 0, 1}}}, {{0}, {{0, 0, 1}}}};
  const std::vector<Update> updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 2U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, std::vector<NodeRef>{11});
  EXPECT_EQ(std::get<PatchVertices>(updates[1]).nodes, std::vector<NodeRef>{13});
}

}  // namespace
}  // namespace sightline::client::cli::playback

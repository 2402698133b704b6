// Updates as parts: all rows arrive in order, and each part fits a message.
#include "server/codec/update_parts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::server::codec {
namespace {

using scenegraph::model::Affine;
using scenegraph::model::DeleteNode;
using scenegraph::model::NodeRef;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

TEST(UpdateParts, NoUpdatesAreNoParts) { EXPECT_TRUE(encode_parts({}).empty()); }

TEST(UpdateParts, SmallUpdatesShareAPart) {
  PutNode put;
  put.name = "four";
  put.labels = std::make_shared<const std::vector<scenegraph::model::Label>>(
      std::vector<scenegraph::model::Label>{{"class", "IfcWindow"}, {"storey", "2"}});
  const std::string encoded = encode_parts({DeleteNode{3, true}, put, DeleteNode{}});
  std::string_view parts = encoded;
  v1::WatchSceneResponse part;
  part.set_more(true);
  take_part(parts, part);
  EXPECT_TRUE(parts.empty());
  EXPECT_FALSE(part.more()) << "it holds its updates and nothing else";
  ASSERT_EQ(part.updates_size(), 3);
  EXPECT_EQ(part.updates(0).delete_node().node(), 3);
  EXPECT_TRUE(part.updates(0).delete_node().subtree());
  EXPECT_EQ(part.updates(1).put_node().name(), "four");
  ASSERT_EQ(part.updates(1).put_node().labels_size(), 2);
  EXPECT_EQ(part.updates(1).put_node().labels(1).key(), "storey");
  EXPECT_EQ(part.updates(1).put_node().labels(1).value(), "2");
  EXPECT_TRUE(part.updates(2).has_delete_node());
}

TEST(UpdateParts, RowsOfLargeUpdatesAreCut) {
  constexpr std::size_t kRows = 100'000;
  SetTransforms moves;
  for (std::size_t i = 0; i < kRows; ++i) moves.nodes.push_back(static_cast<NodeRef>(i + 1));
  moves.parent_from_local.resize(kRows);
  const std::string encoded = encode_parts({DeleteNode{7, false}, moves, DeleteNode{8, false}});
  std::vector<NodeRef> moved;
  std::size_t count = 0;
  for (std::string_view parts = encoded; !parts.empty(); ++count) {
    v1::WatchSceneResponse part;
    take_part(parts, part);
    EXPECT_LE(part.ByteSizeLong(), kPartBytes + kPartBytes / 16);
    for (const v1::Update& update : part.updates()) {
      const auto& nodes = update.set_transforms().nodes();
      moved.insert(moved.end(), nodes.begin(), nodes.end());
      EXPECT_EQ(update.set_transforms().matrices().size(),
                static_cast<std::size_t>(nodes.size()) * sizeof(Affine::m));
    }
  }
  EXPECT_GE(count, kRows * sizeof(Affine::m) / kPartBytes);
  EXPECT_EQ(moved, moves.nodes);
}

}  // namespace
}  // namespace sightline::server::codec

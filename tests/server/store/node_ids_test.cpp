// Lists of node ids as bytes, and back.
#include "server/store/node_ids.h"

#include <gtest/gtest.h>

#include "server/store/sqlite.h"

namespace sightline::server::store {
namespace {

TEST(NodeIds, ReadsWhatItWrites) {
  const std::vector<std::vector<NodeId>> lists{
      {}, {1}, {0}, {~NodeId{0}}, {5, 3, 3, ~NodeId{0}, 0, NodeId{1} << 63}, {1, 2, 3, 4}};
  for (const auto& ids : lists) {
    const std::string bytes = encode_ids(ids);
    EXPECT_EQ(decode_ids(as_bytes(bytes)), ids);
  }
}

TEST(NodeIds, TakeAByteEachInARow) {
  std::vector<NodeId> ids;
  for (NodeId id = 1; id <= 1000; ++id) ids.push_back(id);
  EXPECT_EQ(encode_ids(ids).size(), ids.size());
}

TEST(NodeIds, RefusesWhatItDidNotWrite) {
  EXPECT_EQ(decode_ids(as_bytes("\x80")), std::nullopt);
  EXPECT_EQ(decode_ids(as_bytes(std::string(11, '\xff'))), std::nullopt);
}

}  // namespace
}  // namespace sightline::server::store

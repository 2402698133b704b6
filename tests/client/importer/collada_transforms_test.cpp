// Transforms that float32 holds, and others.
#include "client/importer/collada_transforms.h"

#include <gtest/gtest.h>

#include <string>

#include "client/importer/collada_numbers.h"

namespace sightline::client::importer {
namespace {

double loss_of(const std::string& transforms) {
  const std::string text = "<node id=\"n\">" + transforms + "</node>";
  const auto losses = collada_losses(text);
  return losses.contains("n") ? losses.at("n") : 0;
}

TEST(ColladaTransforms, NumbersThatFloatsHoldLoseNothing) {
  for (const char* const transforms :
       {"", "<translate>1 2 3</translate>", "<translate>4294967296 0,5 -16777216</translate>",
        "<scale>0.1 0.1 0.1</scale>", "<rotate>0 0 1 33</rotate>",
        "<translate>4500000 0 0</translate><rotate>0 0 1 33</rotate>"})
    EXPECT_EQ(loss_of(transforms), 0) << transforms;
}

TEST(ColladaTransforms, FarOffNumbersLoseWhatFloatsLose) {
  EXPECT_NEAR(loss_of("<translate>4294967294 0 0</translate>"), 2, 1e-6);
  EXPECT_NEAR(loss_of("<translate>4512345.7 0 0</translate>"), 0.2, 1e-6);
  EXPECT_NEAR(loss_of("<matrix>1 0 0 0 0 1 0 16777217 0 0 1 0 0 0 0 1</matrix>"), 1, 1e-6);
  EXPECT_NEAR(loss_of("<lookat>4512345.7 0 0 1 0 0 0 1 0</lookat>"), 0.2, 1e-6);
  EXPECT_GT(loss_of("<rotate>0 0 1 33</rotate><translate>4512345 4512345 0</translate>"), 0.01);
}

TEST(ColladaTransforms, NodesHaveTheNamesThatAssimpGivesThem) {
  const auto losses = collada_losses(
      "<node id='a' sid='x'><translate>16777217 0 0</translate>"
      "<node sid='b'><translate>33554433 0 0</translate></node></node>"
      "<node name='c'><translate>67108865 0 0</translate></node><node/>");
  EXPECT_EQ(losses.size(), 3U);
  EXPECT_EQ(losses.at("a"), 1);
  EXPECT_EQ(losses.at("b"), 1);
  EXPECT_EQ(losses.at(""), 1);
}

TEST(ColladaNumbers, MayHaveDecimalCommas) {
  std::string_view text = " 1,5\n-2e3 x";
  EXPECT_EQ(*collada_number(take_collada_word(text)), 1.5);
  EXPECT_EQ(*collada_number(take_collada_word(text)), -2000);
  EXPECT_FALSE(collada_number(take_collada_word(text)));
  EXPECT_EQ(take_collada_word(text), "");
}

}  // namespace
}  // namespace sightline::client::importer

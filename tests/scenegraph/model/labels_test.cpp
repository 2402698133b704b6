// Labels: what is refused, and what is counted.
#include "scenegraph/model/labels.h"

#include <gtest/gtest.h>

namespace sightline::scenegraph::model {
namespace {

Labels labels(std::vector<Label> list) {
  return std::make_shared<const std::vector<Label>>(std::move(list));
}

/// `count` labels whose values have `bytes` bytes.
Labels many(std::size_t count, std::size_t bytes) {
  std::vector<Label> list;
  for (std::size_t i = 0; i < count; ++i)
    list.push_back({"k" + std::to_string(i), std::string(bytes, 'v')});
  return labels(std::move(list));
}

void expect_refused(const Labels& bad, const std::string& reason, const std::string& part) {
  const Status checked = check_labels(bad);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, Code::kInvalidArgument);
  EXPECT_EQ(checked.error().reason, reason);
  EXPECT_NE(checked.error().message.find(part), std::string::npos) << checked.error().message;
}

TEST(Labels, WhatIsWithinTheLimitsIsTaken) {
  EXPECT_TRUE(check_labels(nullptr));
  EXPECT_TRUE(check_labels(labels({{"class", "IfcWindow"}, {"étage", "1er"}, {"empty", ""}})));
  EXPECT_TRUE(check_labels(many(kMaxLabels, 1)));
  EXPECT_TRUE(check_labels(many(10, kMaxLabelValue)));
  EXPECT_TRUE(check_labels(labels({{std::string(kMaxLabelKey, 'k'), "v"}})));
}

TEST(Labels, WhatIsBeyondALimitIsRefusedWithTheValueAndTheLimit) {
  expect_refused(many(kMaxLabels + 1, 1), "TOO_MANY_LABELS", "65 labels, the limit is 64");
  expect_refused(labels({{std::string(65, 'k'), "v"}}), "LABEL_KEY_TOO_LONG",
                 "65 bytes, the limit is 64");
  expect_refused(labels({{"k", std::string(257, 'v')}}), "LABEL_VALUE_TOO_LONG",
                 "\"k\" has 257 bytes, the limit is 256");
  expect_refused(many(20, kMaxLabelValue), "LABELS_TOO_LONG", "5170 bytes, the limit is 4096");
}

TEST(Labels, KeysAreOnceAndNotEmptyAndNothingHasControlCharacters) {
  expect_refused(labels({{"", "v"}}), "LABEL_KEY_EMPTY", "empty key");
  expect_refused(labels({{"a", "1"}, {"b", "2"}, {"a", "1"}}), "LABEL_TWICE", "\"a\" comes twice");
  expect_refused(labels({{"a\n", "1"}}), "LABEL_CONTROL_CHARACTER", "\"a?\"");
  expect_refused(labels({{"a", std::string("1\0", 2)}}), "LABEL_CONTROL_CHARACTER", "\"a\"");
  expect_refused(labels({{"a", "\x7f"}}), "LABEL_CONTROL_CHARACTER", "\"a\"");
}

TEST(Labels, TheirMemoryIsCounted) {
  EXPECT_EQ(bytes_of_labels(nullptr), 0u);
  EXPECT_EQ(bytes_of_labels(labels({{"class", "IfcWindow"}})),
            sizeof(std::vector<Label>) + sizeof(Label) + 14);
}

}  // namespace
}  // namespace sightline::scenegraph::model

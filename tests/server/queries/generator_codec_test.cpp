// Decoding generators of rays.
#include "server/queries/generator_codec.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::server::queries {
namespace {

template <class T>
std::string bytes_of(std::vector<T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

v1::RayGenerator pinhole() {
  v1::RayGenerator generator;
  v1::Pinhole& pinhole = *generator.mutable_pinhole();
  for (const double number : {1, 2, 3}) pinhole.add_eye(number);
  for (const double number : {-1, 1, -1}) pinhole.add_corner(number);
  for (const double number : {2, 0, 0}) pinhole.add_across(number);
  for (const double number : {0, -2, 0}) pinhole.add_down(number);
  for (const double number : {0.5, 0.25, 0.75, 1.0}) pinhole.add_samples(number);
  pinhole.set_width(40);
  pinhole.set_height(30);
  pinhole.set_tiled(true);
  return generator;
}

v1::RayGenerator pairs() {
  v1::RayGenerator generator;
  v1::VisibilityPairs& pairs = *generator.mutable_pairs();
  pairs.set_from(bytes_of<float>({1, 2, 3, 4, 5, 6}));
  pairs.set_to(bytes_of<float>({7, 8, 9}));
  pairs.set_pairs(bytes_of<std::uint32_t>({1, 0}));
  return generator;
}

TEST(DecodeGenerator, DecodesEveryField) {
  v1::RayGenerator message = pinhole();
  message.set_first(7);
  message.set_count(9);
  message.set_tmin(0.5);
  message.set_tmax(4);
  message.set_mask(3);
  const auto generator = decode_generator(message);
  ASSERT_TRUE(generator);
  EXPECT_EQ(generator->first, 7u);
  EXPECT_EQ(generator->count, 9u);
  EXPECT_EQ(generator->tmin, 0.5);
  EXPECT_EQ(generator->tmax, 4);
  EXPECT_EQ(generator->mask, 3u);
  const auto& found = std::get<proto::rays::Pinhole>(generator->rays);
  EXPECT_EQ(found.eye, (proto::rays::Vector{1, 2, 3}));
  EXPECT_EQ(found.down, (proto::rays::Vector{0, -2, 0}));
  EXPECT_EQ(found.samples[1], (std::array<double, 2>{0.75, 1}));
  EXPECT_EQ(found.width, 40u);
  EXPECT_TRUE(found.tiled);
}

TEST(DecodeGenerator, DecodesPoints) {
  const auto generator = decode_generator(pairs());
  ASSERT_TRUE(generator);
  const auto& found = std::get<proto::rays::VisibilityPairs>(generator->rays);
  EXPECT_EQ(found.from[1], (proto::rays::Vector{4, 5, 6}));
  EXPECT_EQ(found.to[0], (proto::rays::Vector{7, 8, 9}));
  EXPECT_EQ(found.pairs[0], (std::array<std::uint32_t, 2>{1, 0}));
  EXPECT_EQ(generator->mask, 0xffffffffu);
  EXPECT_FALSE(generator->tmax);
}

TEST(DecodeGenerator, RefusesWhatIsNotAGenerator) {
  const auto error_of = [](const v1::RayGenerator& message) {
    const auto generator = decode_generator(message);
    EXPECT_FALSE(generator);
    EXPECT_EQ(generator.error().code, Code::kInvalidArgument);
    return generator.error().message;
  };
  EXPECT_EQ(error_of({}), "the generator has no kind that this server knows");
  v1::RayGenerator message = pinhole();
  message.mutable_pinhole()->add_eye(4);
  EXPECT_EQ(error_of(message), "eye has 4 numbers, expected 3");
  message = pinhole();
  message.mutable_pinhole()->add_samples(0);
  EXPECT_EQ(error_of(message), "samples has 5 numbers, expected an even number up to 128");
  message = pinhole();
  message.set_first(2401);
  EXPECT_EQ(error_of(message),
            "rays 2401 and the next 0 are asked for, but the generator has 2400");
  message = pairs();
  message.mutable_pairs()->set_from(std::string(13, '\0'));
  EXPECT_EQ(error_of(message), "column from has 13 bytes, expected a multiple of 12");
  message = pairs();
  message.mutable_pairs()->set_float64(true);
  message.mutable_pairs()->set_to(std::string(24, '\0'));
  EXPECT_EQ(error_of(message), "pair 0 names point 1 of from, which has 1");
  message.Clear();
  message.mutable_scan()->add_azimuth(1);
  EXPECT_EQ(error_of(message), "origin has 0 numbers, expected 3");
}

}  // namespace
}  // namespace sightline::server::queries

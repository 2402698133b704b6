// Pictures that come back as they went.
#include "client/cli/picture/png.h"

#include <gtest/gtest.h>
#include <png.h>

#include <string>
#include <vector>

namespace sightline::client::cli::picture {
namespace {

TEST(Png, ComesBackTheSame) {
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < 7 * 5 * 3; ++i) rgb.push_back(static_cast<std::uint8_t>(i * 37));
  const auto bytes = encode_png(rgb, 7, 5);
  ASSERT_TRUE(bytes) << bytes.error().message;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, bytes->data(), bytes->size()), 0);
  EXPECT_EQ(image.width, 7U);
  EXPECT_EQ(image.height, 5U);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr), 0);
  EXPECT_EQ(read, rgb);
}

}  // namespace
}  // namespace sightline::client::cli::picture

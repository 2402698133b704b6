// The pixels of a picture in the order in which their rays are cast.
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/rays/generator.h"

namespace sightline::proto::rays {

/// Visits pixels one after the other. Threads: one.
class PixelWalk {
 public:
  /// Begins at pixel number `pixel` of the picture, which has it.
  PixelWalk(const Pinhole& picture, std::uint64_t pixel)
      : width_(picture.width),
        height_(picture.height),
        tile_width_(picture.tiled ? kTile : picture.width),
        tile_height_(picture.tiled ? kTile : 1) {
    const std::uint64_t band = pixel / (std::uint64_t{tile_height_} * width_);
    top_ = static_cast<std::uint32_t>(band) * tile_height_;
    const std::uint64_t in_band = pixel - std::uint64_t{top_} * width_;
    const std::uint64_t tile = in_band / (std::uint64_t{tile_width_} * rows());
    left_ = static_cast<std::uint32_t>(tile) * tile_width_;
    const auto in_tile = static_cast<std::uint32_t>(in_band - std::uint64_t{left_} * rows());
    x_ = left_ + in_tile % columns();
    y_ = top_ + in_tile / columns();
  }

  std::uint32_t x() const { return x_; }
  std::uint32_t y() const { return y_; }

  void next() {
    if (++x_ < left_ + columns()) return;
    x_ = left_;
    if (++y_ < top_ + rows()) return;
    y_ = top_;
    left_ += tile_width_;
    if (left_ >= width_) {
      left_ = 0;
      top_ += tile_height_;
      y_ = top_;
    }
    x_ = left_;
  }

 private:
  /// The columns of the tile, which the edges of the picture may cut off.
  std::uint32_t columns() const { return std::min(tile_width_, width_ - left_); }
  std::uint32_t rows() const { return std::min(tile_height_, height_ - top_); }

  const std::uint32_t width_, height_, tile_width_, tile_height_;
  std::uint32_t left_ = 0, top_ = 0;  // the tile's
  std::uint32_t x_ = 0, y_ = 0;
};

}  // namespace sightline::proto::rays

// A bar of one line.
#include "client/cli/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace sightline::client::cli {
namespace {

constexpr std::size_t kBarWidth = 32;
constexpr std::chrono::milliseconds kBetweenDrawings{50};

}  // namespace

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), is_terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressBar::update(double fraction) {
  if (!is_terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kBetweenDrawings;
  shown_ = true;
  const double part = std::clamp(fraction, 0.0, 1.0);
  const auto full = static_cast<std::size_t>(part * static_cast<double>(kBarWidth));
  fmt::print(stderr, "\r{} [{}{}] {:3.0f} %", label_, std::string(full, '#'),
             std::string(kBarWidth - full, ' '), 100 * part);
  std::fflush(stderr);
}

}  // namespace sightline::client::cli

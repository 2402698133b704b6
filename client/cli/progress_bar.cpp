// A bar of one line, or lines of their own.
#include "client/cli/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace sightline::client::cli {
namespace {

constexpr std::size_t kBarWidth = 32;
constexpr std::size_t kBarWidthBesideDetail = 16;
constexpr std::chrono::milliseconds kBetweenDrawings{50};
constexpr std::chrono::milliseconds kBetweenLines{1000};

// A line that wraps could not be wiped.
std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

}  // namespace

ProgressBar::ProgressBar(std::string label, Elsewhere elsewhere)
    : label_(std::move(label)), elsewhere_(elsewhere), is_terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressBar::update(double fraction, std::string_view detail) {
  if (!is_terminal_ && elsewhere_ == Elsewhere::kNothing) return;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + (is_terminal_ ? kBetweenDrawings : kBetweenLines);
  if (is_terminal_) {
    draw(fraction, detail);
  } else {
    fmt::print(stderr, "{}: {}\n", label_, detail);
  }
  std::fflush(stderr);
}

void ProgressBar::draw(double fraction, std::string_view detail) {
  shown_ = true;
  const double part = std::clamp(fraction, 0.0, 1.0);
  const std::size_t width = detail.empty() ? kBarWidth : kBarWidthBesideDetail;
  const auto full = static_cast<std::size_t>(part * static_cast<double>(width));
  std::string line = fmt::format("{} [{}{}] {:3.0f} %", label_, std::string(full, '#'),
                                 std::string(width - full, ' '), 100 * part);
  if (!detail.empty()) line += fmt::format("  {}", detail);
  line.resize(std::min(line.size(), terminal_width() - 1));
  fmt::print(stderr, "\r{}\x1b[K", line);
}

}  // namespace sightline::client::cli

// Exit codes and messages, the signal handler, the bar, and number formats.
#include "client/cli/terminal.h"

#include <fmt/format.h>
#include <semaphore.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "client/cli/reporting.h"

namespace sightline::client::cli {
namespace {

sem_t woken;
constexpr std::array<int, 2> kSignals{SIGINT, SIGTERM};
std::atomic<int> caught{0};
static_assert(std::atomic<int>::is_always_lock_free, "it is written by a signal handler");

void handle(int signal) {
  const int kept = errno;
  caught.store(signal, std::memory_order_relaxed);
  sem_post(&woken);
  errno = kept;
}

constexpr std::size_t kBarWidth = 32;
constexpr std::size_t kBarWidthBesideDetail = 16;
constexpr std::chrono::milliseconds kBetweenDrawings{50};
constexpr std::chrono::milliseconds kBetweenLines{1000};

// A line that wraps could not be erased.
std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

// A part below the whole is never printed as 100 %, and a part above 0 never as 0 %.
std::string percent(std::uint64_t part, std::uint64_t whole) {
  const double value = 100 * static_cast<double>(part) / static_cast<double>(whole);
  if (part < whole && value > 99.9) return "99.9 %";
  if (part > 0 && value < 0.1) return "below 0.1 %";
  return fmt::format("{:.{}f} %", value, part == whole || part == 0 ? 0 : 1);
}

// The length in bytes of the character at the front; 0: a control character, or no UTF-8.
std::size_t printable_length(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = at(0);
  if (first < 0x80) return first < ' ' || first == 0x7F ? 0 : 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const std::size_t length = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((at(i) & 0xC0U) != 0x80U) return 0;
  }
  const bool is_control = first == 0xC2 && at(1) < 0xA0;  // U+0080 to U+009F
  return is_control ? 0 : length;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = printable_length(text);
    if (length > 0) {
      out += text.substr(0, length);
    } else {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

ExitCode exit_code(Code code) {
  switch (code) {
    case Code::kNotFound:
      return kNotFound;
    case Code::kAlreadyExists:
    case Code::kFailedPrecondition:
    case Code::kAborted:
      return kConflict;
    case Code::kUnavailable:
    case Code::kDeadlineExceeded:
      return kUnavailable;
    case Code::kUnauthenticated:
    case Code::kPermissionDenied:
      return kAuth;
    case Code::kResourceExhausted:
      return kResourceLimit;
    default:
      return kFailed;
  }
}

ExitCode fail(const Error& error) {
  const ExitCode exit = exit_code(error.code);
  print_error(error, exit);
  return exit;
}

ExitCode interrupted_code() {
  return caught.load(std::memory_order_relaxed) == SIGTERM ? kTerminated : kInterrupted;
}

ExitCode say_interrupted() {
  const ExitCode exit = interrupted_code();
  print_error({Code::kCancelled, "interrupted", {}}, exit);
  return exit;
}

Error local_error(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

Interrupt::Interrupt() {
  sem_init(&woken, 0, 0);
  caught.store(0, std::memory_order_relaxed);
  waiter_ = std::thread([this] { wait(); });
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  sem_post(&woken);
  waiter_.join();
  sem_destroy(&woken);
}

void Interrupt::wait() {
  while (sem_wait(&woken) != 0) {
  }
  if (caught.load(std::memory_order_relaxed) != 0) stop_.request_stop();
}

ProgressBar::ProgressBar(std::string label, Elsewhere elsewhere)
    : label_(std::move(label)), elsewhere_(elsewhere), is_terminal_(is_stderr_a_terminal()) {}

ProgressBar::~ProgressBar() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressBar::update(double fraction, std::string_view detail) {
  if (is_quiet() || (!is_terminal_ && elsewhere_ == Elsewhere::kNothing)) return;
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

void ProgressBar::update_amount(std::uint64_t done, std::uint64_t total, Unit unit) {
  const double seconds = seconds_since_start();
  const auto rate = seconds > 0 ? static_cast<std::uint64_t>(static_cast<double>(done) / seconds)
                                : std::uint64_t{0};
  const auto text = [unit](std::uint64_t amount) {
    if (unit == Unit::kBytes) return format_bytes(amount);
    return format_count(amount) + (unit == Unit::kRays ? " rays" : " points");
  };
  update(share(done, total), fmt::format("{}, {}/s", text(done), text(rate)));
}

double ProgressBar::seconds_since_start() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

// The time that is left; empty before there is anything to judge by.
std::string ProgressBar::time_left(double fraction) const {
  const double seconds = seconds_since_start();
  if (seconds < 1 || !(fraction > 0) || fraction >= 1) return {};
  const double left = std::ceil(seconds * (1 - fraction) / fraction);
  if (left < 120) return fmt::format(", {:.0f} s left", left);
  if (left < 7200) return fmt::format(", {:.0f} min left", std::ceil(left / 60));
  return fmt::format(", {:.0f} h left", std::ceil(left / 3600));
}

void ProgressBar::draw(double fraction, std::string_view detail) {
  shown_ = true;
  const double part = std::clamp(fraction, 0.0, 1.0);
  const std::size_t width = detail.empty() ? kBarWidth : kBarWidthBesideDetail;
  const auto full = static_cast<std::size_t>(part * static_cast<double>(width));
  std::string line = fmt::format("{} [{}{}] {:3.0f} %{}", label_, std::string(full, '#'),
                                 std::string(width - full, ' '), 100 * part, time_left(part));
  if (!detail.empty()) line += fmt::format("  {}", detail);
  line.resize(std::min(line.size(), terminal_width() - 1));
  fmt::print(stderr, "\r{}\x1b[K", line);
}

std::string format_count(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t position = text.size(); position > 3;) {
    position -= 3;
    text.insert(position, ",");
  }
  return text;
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string format_share(std::uint64_t part, std::uint64_t whole) {
  std::string text = format_count(part) + " of " + format_count(whole);
  if (whole > 0) text += " (" + percent(part, whole) + ")";
  return text;
}

std::string format_bytes(std::uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  constexpr std::array<const char*, 4> kUnits{"kB", "MB", "GB", "TB"};
  double amount = static_cast<double>(bytes) / 1000;
  std::size_t unit = 0;
  for (; amount >= 999.95 && unit + 1 < kUnits.size(); ++unit) amount /= 1000;
  return fmt::format("{:.1f} {}", amount, kUnits[unit]);
}

}  // namespace sightline::client::cli

// The command's side of the terminal: exit codes, Ctrl-C, a progress bar, and numbers as text.
#pragma once

#include <signal.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "client/result.h"

namespace sightline::client::cli {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,  ///< or a local file cannot be read or written
  kUsage = 2,
  kNotFound = 3,  ///< the server does not know a scene or node
  kConflict = 4,
  kUnavailable = 5,  ///< or the deadline has passed
  kAuth = 6,
  kResourceLimit = 7,
  kInterrupted = 130,  ///< by Ctrl-C
  kTerminated = 143,   ///< by SIGTERM
};

ExitCode exit_code(Code code);

/// Text of a file or of a server, without effect on a terminal: the bytes of control characters,
/// and bytes that are no UTF-8, become \xNN.
std::string printable(std::string_view text);

/// Prints the error on stderr, as text or as JSON, and returns its exit code.
ExitCode fail(const Error& error);

/// The exit code of a command that an Interrupt has ended: kInterrupted or kTerminated.
ExitCode interrupted_code();

/// Prints that the command was interrupted, and returns interrupted_code().
ExitCode say_interrupted();

/// An error about a file of this machine, as kInvalidArgument.
Error local_error(std::string message);

/// While an object exists, the first SIGINT or SIGTERM requests a stop instead of ending the
/// process; the same signal once more ends it. Only one object may exist at a time.
class Interrupt {
 public:
  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  std::stop_token token() const { return stop_.get_token(); }
  bool happened() const { return stop_.stop_requested(); }

 private:
  void wait();

  std::stop_source stop_;
  std::array<struct sigaction, 2> before_{};
  std::thread waiter_;
};

class ProgressBar {
 public:
  /// What is printed if stderr is not a terminal: nothing, or one line per second.
  enum class Elsewhere { kNothing, kLines };

  explicit ProgressBar(std::string label, Elsewhere elsewhere = Elsewhere::kNothing);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  ///< erases the line

  /// `fraction` runs from 0 to 1. `detail` is printed behind the bar, and is the text of a plain
  /// line. Cheap, so it may be called often.
  void update(double fraction, std::string_view detail = {});

  enum class Unit { kBytes, kRays, kPoints };
  /// Updates the bar with the amount and the rate as detail.
  void update_amount(std::uint64_t done, std::uint64_t total, Unit unit);

 private:
  void draw(double fraction, std::string_view detail);
  double seconds_since_start() const;
  std::string time_left(double fraction) const;

  std::string label_;
  Elsewhere elsewhere_;
  bool shown_ = false;
  bool is_terminal_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point next_{};
};

/// Formats 1234567 as "1,234,567".
std::string format_count(std::uint64_t number);

/// part / whole, or 0 if `whole` is 0.
double share(std::uint64_t part, std::uint64_t whole);

/// Formats "1,234 of 75,730 (1.6 %)". The percentage is left out if `whole` is 0.
std::string format_share(std::uint64_t part, std::uint64_t whole);

/// Formats "12.3 MB", in steps of 1,000. Below 1,000: "321 B".
std::string format_bytes(std::uint64_t bytes);

}  // namespace sightline::client::cli

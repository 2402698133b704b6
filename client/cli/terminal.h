// What a user of the command meets: exit codes, Ctrl-C, a progress bar, numbers as text.
#pragma once

#include <signal.h>
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
  kFailed = 1,  ///< Also a local file that cannot be read or written.
  kUsage = 2,
  kNotFound = 3,  ///< A scene or node that the server does not know.
  kConflict = 4,
  kUnavailable = 5,  ///< Or out of time.
  kAuth = 6,
  kResourceLimit = 7,
  kInterrupted = 130,  ///< By Ctrl-C.
};

ExitCode exit_code(Code code);

/// Says on stderr what went wrong, and returns the exit code for it.
ExitCode fail(const Error& error);

/// Says so, and returns kInterrupted.
ExitCode say_interrupted();

/// An error of this machine's files, as kInvalidArgument.
Error local_error(std::string message);

/// While it lives, the first SIGINT requests a stop instead of ending the process. A second one
/// ends it as ever. One at a time.
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
  struct sigaction before_ {};
  std::thread waiter_;
};

class ProgressBar {
 public:
  /// What is shown where stderr is no terminal: nothing, or a line a second.
  enum class Elsewhere { kNothing, kLines };

  explicit ProgressBar(std::string label, Elsewhere elsewhere = Elsewhere::kNothing);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  ///< Wipes the line.

  /// `fraction` from 0 to 1; `detail` stands behind it, and is what a plain line tells. Cheap to
  /// call often.
  void update(double fraction, std::string_view detail = {});

 private:
  void draw(double fraction, std::string_view detail);

  std::string label_;
  Elsewhere elsewhere_;
  bool shown_ = false;
  bool is_terminal_ = false;
  std::chrono::steady_clock::time_point next_{};
};

/// 1234567 as "1,234,567".
std::string format_count(std::uint64_t number);

/// "1,234 of 75,730 (1.6 %)"; without a share of nothing.
std::string format_share(std::uint64_t part, std::uint64_t whole);

/// "12.3 MB", in steps of 1,000; below 1,000 "321 B".
std::string format_bytes(std::uint64_t bytes);

}  // namespace sightline::client::cli

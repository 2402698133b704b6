// How far something has come, on one line of stderr; silent unless that is a terminal.
#pragma once

#include <chrono>
#include <string>

namespace sightline::client::cli {

class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  ///< Wipes the line.

  /// `fraction` from 0 to 1. Cheap to call often.
  void update(double fraction);

 private:
  std::string label_;
  bool shown_ = false;
  bool is_terminal_ = false;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace sightline::client::cli

// How far something has come, on one line of stderr.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace sightline::client::cli {

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

}  // namespace sightline::client::cli

// Plots as inline SVG, whose colours are those of the page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/load/crossover.h"
#include "client/load/report/axis.h"

namespace sightline::client::load::report {

/// Numbers of colours begin at 0 and repeat after this many.
inline constexpr int kColours = 4;

struct Series {
  std::string name;
  int colour = 0;
  std::vector<Point> points;  ///< by rising x
  bool with_dots = false;
};

/// A vertical line, with text at its top.
struct Mark {
  double x = 0;
  std::string text;
};

struct LinePlot {
  std::string title;  ///< for those who do not see it
  std::string x_label, y_label;
  Axis x, y;
  std::vector<Series> series;
  std::optional<Mark> mark{};
};
std::string to_svg(const LinePlot& plot);

/// Bars from left to right, one below the other, each in parts.
struct BarPlot {
  struct Bar {
    std::string label;
    std::vector<double> parts;
    std::string value;  ///< beside the bar
    int colour = 0;     ///< its first part's; the next have the next ones
  };
  std::string title;
  std::vector<std::string> parts;  ///< names for a legend; empty: none
  std::vector<Bar> bars;
};
std::string to_svg(const BarPlot& plot);

}  // namespace sightline::client::load::report

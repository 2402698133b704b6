// Writes SVG. Classes of the page's style give colours and fonts.
#include "client/load/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "client/load/report/text.h"

namespace sightline::client::load::report {
namespace {

constexpr double kWidth = 720, kHeight = 320;
constexpr double kLeft = 78, kRight = 18, kTop = 34, kBottom = 52;
constexpr double kBarRow = 26, kBarLeft = 130, kBarRight = 110;

class Svg {
 public:
  Svg(double width, double height, const std::string& title) {
    add(R"(<svg viewBox="0 0 {:.0f} {:.0f}" role="img" aria-label="{}">)", width, height,
        escape(title));
  }
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  void line(const char* kind, double x1, double y1, double x2, double y2) {
    add(R"(<line class="{}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>)", kind, x1, y1, x2,
        y2);
  }
  void text(double x, double y, const char* anchor, const std::string& words,
            const char* kind = "label") {
    add(R"(<text class="{}" x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", kind, x, y, anchor,
        escape(words));
  }
  std::string finish() { return std::move(text_) + "</svg>\n"; }

 private:
  std::string text_;
};

double x_of(const LinePlot& plot, double value) {
  return kLeft + (kWidth - kLeft - kRight) * plot.x.position(value);
}
double y_of(const LinePlot& plot, double value) {
  return kHeight - kBottom - (kHeight - kTop - kBottom) * plot.y.position(value);
}

void draw_axes(const LinePlot& plot, Svg& svg) {
  const double bottom = kHeight - kBottom, right = kWidth - kRight;
  for (const Tick& tick : plot.y.ticks()) {
    const double y = y_of(plot, tick.value);
    svg.line("grid", kLeft, y, right, y);
    svg.text(kLeft - 8, y + 4, "end", tick.label);
  }
  for (const Tick& tick : plot.x.ticks()) {
    const double x = x_of(plot, tick.value);
    svg.line("grid", x, kTop, x, bottom);
    svg.text(x, bottom + 18, "middle", tick.label);
  }
  svg.line("axis", kLeft, bottom, right, bottom);
  svg.text((kLeft + right) / 2, kHeight - 10, "middle", plot.x_label, "name");
  svg.add(R"svg(<g transform="translate(16 {:.1f}) rotate(-90)">)svg", (kTop + bottom) / 2);
  svg.text(0, 0, "middle", plot.y_label, "name");
  svg.add("</g>");
}

void draw_series(const LinePlot& plot, const Series& series, Svg& svg) {
  const int colour = series.colour % kColours;
  svg.add(R"(<polyline class="curve c{}" points=")", colour);
  for (const Point& point : series.points)
    svg.add("{:.1f},{:.1f} ", x_of(plot, point.x), y_of(plot, point.y));
  svg.add(R"("/>)");
  if (!series.with_dots) return;
  for (const Point& point : series.points) {
    svg.add(R"(<circle class="dot f{}" cx="{:.1f}" cy="{:.1f}" r="3.5"/>)", colour,
            x_of(plot, point.x), y_of(plot, point.y));
  }
}

// Names above the plot, from left to right. The text's width is estimated.
void draw_legend(const std::vector<std::string>& names, const std::vector<int>& colours, double x,
                 Svg& svg) {
  constexpr double kSwatch = 14, kLetter = 7.2, kGap = 22;
  for (std::size_t i = 0; i < names.size(); ++i) {
    svg.add(R"(<rect class="f{}" x="{:.1f}" y="11" width="{}" height="8" rx="2"/>)",
            colours[i] % kColours, x, kSwatch);
    svg.text(x + kSwatch + 6, 19, "start", names[i]);
    x += kSwatch + 6 + kLetter * static_cast<double>(names[i].size()) + kGap;
  }
}

void draw_mark(const LinePlot& plot, const Mark& mark, Svg& svg) {
  const double x = x_of(plot, mark.x);
  svg.line("mark", x, kTop, x, kHeight - kBottom);
  const bool is_right = x > (kLeft + kWidth - kRight) / 2;
  svg.text(is_right ? x - 6 : x + 6, kTop + 14, is_right ? "end" : "start", mark.text, "mark");
}

}  // namespace

std::string to_svg(const LinePlot& plot) {
  Svg svg(kWidth, kHeight, plot.title);
  draw_axes(plot, svg);
  if (plot.mark) draw_mark(plot, *plot.mark, svg);
  std::vector<std::string> names;
  std::vector<int> colours;
  for (const Series& series : plot.series) {
    draw_series(plot, series, svg);
    names.push_back(series.name);
    colours.push_back(series.colour);
  }
  draw_legend(names, colours, kLeft, svg);
  return svg.finish();
}

std::string to_svg(const BarPlot& plot) {
  const double top = plot.parts.empty() ? 8 : kTop;
  Svg svg(kWidth, top + kBarRow * static_cast<double>(plot.bars.size()) + 6, plot.title);
  std::vector<int> colours(plot.parts.size());
  std::iota(colours.begin(), colours.end(), 0);
  draw_legend(plot.parts, colours, kBarLeft, svg);
  double longest = 0;
  for (const BarPlot::Bar& bar : plot.bars)
    longest = std::max(longest, std::accumulate(bar.parts.begin(), bar.parts.end(), 0.0));
  const double scale = longest > 0 ? (kWidth - kBarLeft - kBarRight) / longest : 0;
  double y = top;
  for (const BarPlot::Bar& bar : plot.bars) {
    svg.text(kBarLeft - 10, y + 17, "end", bar.label);
    double x = kBarLeft;
    for (std::size_t i = 0; i < bar.parts.size(); ++i) {
      const double width = bar.parts[i] * scale;
      svg.add(R"(<rect class="f{}" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.0f}"/>)",
              (bar.colour + static_cast<int>(i)) % kColours, x, y + 4, width, kBarRow - 8);
      x += width;
    }
    svg.text(x + 8, y + 17, "start", bar.value);
    y += kBarRow;
  }
  return svg.finish();
}

}  // namespace sightline::client::load::report

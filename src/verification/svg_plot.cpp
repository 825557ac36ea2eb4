#include "verification/svg_plot.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sanatrix::verification {
namespace {

// Colours of Okabe and Ito, told apart by colour-blind readers too.
constexpr std::array colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                             "#e69f00", "#56b4e9", "#000000", "#999999"};
constexpr double width = 640, height = 400, left = 78, right = 16, top = 34, bottom = 52;

/// One axis: data to pixels, and where its ticks are.
struct Axis {
  bool log = false;
  double low = 0.0, high = 1.0, from = 0.0, to = 1.0;

  [[nodiscard]] double scaled(double v) const { return log ? std::log10(v) : v; }
  [[nodiscard]] double pixel(double v) const {
    return from + (to - from) * (scaled(v) - scaled(low)) / (scaled(high) - scaled(low));
  }
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> at;
    if (log) {
      const bool narrow = std::log10(high / low) < 1.5;
      for (double decade = std::pow(10.0, std::floor(std::log10(low) + 1e-9)); decade <= high;
           decade *= 10.0) {
        for (const double m : narrow ? std::vector{1.0, 2.0, 5.0} : std::vector{1.0}) {
          if (m * decade >= low * (1 - 1e-9) && m * decade <= high * (1 + 1e-9)) {
            at.push_back(m * decade);
          }
        }
      }
      return at;
    }
    const double raw = (high - low) / 5.0;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    const double step = power * (raw / power < 1.5   ? 1
                                 : raw / power < 3.5 ? 2
                                 : raw / power < 7.5 ? 5
                                                     : 10);
    for (double t = std::ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) {
      at.push_back(std::abs(t) < 1e-9 * step ? 0.0 : t);
    }
    return at;
  }
};

Axis make_axis(const Plot& plot, std::vector<double> Curve::*values, bool log, double from,
               double to) {
  double low = 1e300;
  double high = -1e300;
  const auto show = [&](double v) {
    if (std::isfinite(v) && (!log || v > 0.0)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  };
  for (const Curve& curve : plot.curves) {
    const auto& at = curve.*values;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const bool has_bar = values == &Curve::y && i < curve.error_bar.size();
      const double bar = has_bar ? curve.error_bar[i] : 0.0;
      show(at[i] - bar);
      show(at[i] + bar);
    }
  }
  if (log) {
    return {true, low / 1.25, high * 1.25, from, to};
  }
  const double margin = high > low ? 0.04 * (high - low) : 0.5 * std::max(1.0, std::abs(high));
  return {false, low - margin, high + margin, from, to};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  }
  return out;
}

std::string axes(const Plot& plot, const Axis& x, const Axis& y) {
  std::string s;
  for (const double t : x.ticks()) {
    s += fmt::format(
        "<line x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}' stroke='#ddd'/>"
        "<text x='{0:.1f}' y='{3:.1f}' text-anchor='middle'>{4:.4g}</text>\n",
        x.pixel(t), top, height - bottom, height - bottom + 17, t);
  }
  for (const double t : y.ticks()) {
    s += fmt::format(
        "<line x1='{1:.1f}' y1='{0:.1f}' x2='{2:.1f}' y2='{0:.1f}' stroke='#ddd'/>"
        "<text x='{3:.1f}' y='{4:.1f}' text-anchor='end'>{5:.4g}</text>\n",
        y.pixel(t), left, width - right, left - 7, y.pixel(t) + 4, t);
  }
  s += fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#444'/>\n", left,
                   top, width - left - right, height - top - bottom);
  s += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n",
                   0.5 * (left + width - right), height - 14, escaped(plot.x_label));
  s +=
      fmt::format("<text transform='translate(18 {}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                  0.5 * (top + height - bottom), escaped(plot.y_label));
  return s + fmt::format("<text x='{}' y='20' text-anchor='middle' font-weight='bold'>{}</text>\n",
                         0.5 * (left + width - right), escaped(plot.title));
}

std::string curve_marks(const Curve& curve, const Axis& x, const Axis& y, const char* colour) {
  std::string line;
  std::string marks;
  const bool few = curve.x.size() <= 20;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!std::isfinite(curve.y[i]) || (y.log && curve.y[i] <= 0.0)) {
      continue;
    }
    const double px = x.pixel(curve.x[i]);
    const double py = y.pixel(curve.y[i]);
    line += fmt::format("{:.1f},{:.1f} ", px, py);
    if (few) {
      marks += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3.2' fill='{}'/>\n", px, py, colour);
    }
    if (i < curve.error_bar.size()) {
      marks +=
          fmt::format("<line x1='{0:.1f}' y1='{1:.1f}' x2='{0:.1f}' y2='{2:.1f}' stroke='{3}'/>\n",
                      px, y.pixel(curve.y[i] - curve.error_bar[i]),
                      y.pixel(curve.y[i] + curve.error_bar[i]), colour);
    }
  }
  if (!curve.markers_only) {
    marks += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='1.8'/>\n",
                         line, colour);
  }
  return marks;
}

}  // namespace

std::string svg_plot(const Plot& plot) {
  const Axis x = make_axis(plot, &Curve::x, plot.log_x, left, width - right);
  const Axis y = make_axis(plot, &Curve::y, plot.log_y, height - bottom, top);
  const double legend = 16.0 * static_cast<double>(plot.curves.size()) + 8.0;
  std::string s = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='{1}' viewBox='0 0 {0} {1}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='{0}' height='{1}' fill='white'/>\n",
      width, height + legend);
  s += axes(plot, x, y);
  for (std::size_t c = 0; c < plot.curves.size(); ++c) {
    const char* colour = colours[c % colours.size()];
    s += curve_marks(plot.curves[c], x, y, colour);
    const double at = height + 16.0 * static_cast<double>(c) + 4.0;
    s += fmt::format(
        "<rect x='{}' y='{}' width='18' height='4' fill='{}'/><text x='{}' y='{}'>{}</text>\n",
        left, at - 5, colour, left + 26, at, escaped(plot.curves[c].name));
  }
  return s + "</svg>\n";
}

}  // namespace sanatrix::verification

#include "report/html.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/files.hpp"

namespace sanatrix::report {
namespace {

std::string base64(const std::string& bytes) {
  constexpr auto letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      value = value << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : letters[value >> (18 - 6 * k) & 63U];
    }
  }
  return out;
}

// Okabe and Ito's colours, distinguishable by colour-blind readers.
constexpr std::array colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000"};

/// 1, 2 or 5 times a power of ten, so that about five steps make the range.
double nice_step(double range) {
  const double raw = std::max(range, 1e-12) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= raw) {
      return step * power;
    }
  }
  return 10 * power;
}

struct Frame {
  double x0, x1, y0, y1;
  static constexpr double width = 640, height = 300, left = 64, right = 16, top = 14, bottom = 48;

  [[nodiscard]] double px(double x) const {
    return left + (x - x0) / (x1 - x0) * (width - left - right);
  }
  [[nodiscard]] double py(double y) const {
    return height - bottom - (y - y0) / (y1 - y0) * (height - top - bottom);
  }
  [[nodiscard]] std::string axes(const std::string& x_label, const std::string& y_label) const {
    std::string svg =
        fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#999'/>", left,
                    top, width - left - right, height - top - bottom);
    const double dx = nice_step(x1 - x0), dy = nice_step(y1 - y0);
    for (double x = std::ceil(x0 / dx - 1e-9) * dx; x <= x1 + 1e-9 * dx; x += dx) {
      svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{:g}</text>", px(x),
                         height - bottom + 17, std::abs(x) < 1e-9 * dx ? 0.0 : x);
    }
    for (double y = std::ceil(y0 / dy - 1e-9) * dy; y <= y1 + 1e-9 * dy; y += dy) {
      svg += fmt::format(
          "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#e4e4e4'/>"
          "<text x='{3}' y='{4:.1f}' text-anchor='end'>{5:g}</text>",
          left, width - right, py(y), left - 7, py(y) + 4, std::abs(y) < 1e-9 * dy ? 0.0 : y);
    }
    svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>",
                       0.5 * (left + width - right), height - 10, escaped(x_label));
    return svg +
           fmt::format(
               "<text transform='translate(15,{}) rotate(-90)' text-anchor='middle'>{}</text>",
               0.5 * (top + height - bottom), escaped(y_label));
  }
};

std::string svg(const std::string& inside, const std::string& label) {
  return fmt::format(
      "<svg viewBox='0 0 {} {}' role='img' aria-label='{}' font-size='12.5' "
      "font-family='sans-serif' fill='#222'>{}</svg>",
      Frame::width, Frame::height, escaped(label), inside);
}

constexpr auto style = R"css(
:root{color-scheme:light}
body{font:16px/1.5 system-ui,"Segoe UI","DejaVu Sans",sans-serif;color:#1c1c1c;background:#fff;margin:0 auto;max-width:1080px;padding:0 18px 40px}
h1{font-size:1.7em;margin:.6em 0 .2em}h2{font-size:1.3em;margin:1.7em 0 .5em;border-bottom:2px solid #0072b2;padding-bottom:.15em}h3{font-size:1.05em;margin:1.2em 0 .3em}
.notice{background:#fff3cd;border:1px solid #b98900;padding:.5em .9em;border-radius:5px;font-weight:600}
.quiet{color:#595959;font-size:.88em}
table{border-collapse:collapse;width:100%;margin:.5em 0}th,td{padding:.28em .55em;text-align:left;vertical-align:top;border-bottom:1px solid #ddd}
th{background:#f2f5f7}td.n,th.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
tr.noise td{color:#636363;background:#f6f6f6}td br+.quiet{font-size:.8em;line-height:1.3}tr.group th{background:#e3edf4}
.wide{overflow-x:auto}img,svg{max-width:100%;height:auto;display:block;margin:.4em auto}
svg{max-width:680px}figure{margin:1em 0}figcaption{color:#444;font-size:.9em}
.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(190px,1fr));gap:.7em;padding:0;list-style:none}
.facts li{border:1px solid #cfd8de;border-radius:6px;padding:.5em .8em}.facts b{display:block;font-size:1.25em}
details{margin:1em 0}summary{cursor:pointer;font-weight:600;padding:.3em 0}
summary:focus-visible{outline:3px solid #0072b2}code{word-break:break-all;font-size:.86em}
@media (max-width:700px){figure{overflow-x:auto}figure img{max-width:none;width:960px}}
@media print{figure img{width:auto;max-width:100%}@page{size:A4;margin:14mm}body{font-size:10.5pt;max-width:none;padding:0}figure,tr,.facts li{break-inside:avoid}h2,h3{break-after:avoid}.page{break-before:page}.wide{overflow:visible}td,th{padding:.16em .4em}}
)css";

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string embedded_picture(const std::filesystem::path& png, const std::string& alternative) {
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", escaped(alternative),
                     base64(read_text(png)));
}

std::string line_chart(const std::vector<Line>& lines, const std::string& x_label,
                       const std::string& y_label) {
  Frame frame{1e300, -1e300, 1e300, -1e300};
  for (const Line& line : lines) {
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      frame.x0 = std::min(frame.x0, line.x[i]);
      frame.x1 = std::max(frame.x1, line.x[i]);
      frame.y0 = std::min(frame.y0, line.y[i]);
      frame.y1 = std::max(frame.y1, line.y[i]);
    }
  }
  if (!(frame.x1 > frame.x0)) {
    return {};
  }
  const double room = std::max(0.06 * (frame.y1 - frame.y0), 1e-6);
  frame.y0 -= room;
  frame.y1 += room;
  std::string inside = frame.axes(x_label, y_label);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string points;
    for (std::size_t k = 0; k < lines[i].x.size(); ++k) {
      points += fmt::format("{:.1f},{:.1f} ", frame.px(lines[i].x[k]), frame.py(lines[i].y[k]));
    }
    const char* colour = colours[i % colours.size()];
    inside += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2.2'/>",
                          points, colour);
    if (lines.size() > 1) {
      inside += fmt::format("<text x='{}' y='{}' fill='{}' text-anchor='end'>{}</text>",
                            Frame::width - Frame::right - 8, Frame::top + 18 + 17 * i, colour,
                            escaped(lines[i].name));
    }
  }
  return svg(inside, y_label + " over " + x_label);
}

std::string bar_chart(const std::vector<double>& shares, double bin, const std::string& x_label,
                      const std::string& y_label) {
  const double highest = shares.empty() ? 1.0 : *std::ranges::max_element(shares);
  const Frame frame{0, bin * static_cast<double>(shares.size()), 0, std::max(1.08 * highest, 1e-6)};
  std::string inside = frame.axes(x_label, y_label);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double x = frame.px(bin * static_cast<double>(i));
    inside +=
        fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}'/>", x + 1,
                    frame.py(shares[i]), frame.px(bin * static_cast<double>(i + 1)) - x - 2,
                    frame.py(0) - frame.py(shares[i]), colours[0]);
  }
  return svg(inside, y_label + " over " + x_label);
}

std::string page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'\"><title>{}</title><style>{}</style></head><body>\n{}\n</body>"
      "</html>\n",
      escaped(title), style, body);
}

}  // namespace sanatrix::report

// Pieces of a self-contained page: escaped text, pictures and charts inside the file, no scripts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sanatrix::report {

/// Text that may come from outside, safe inside elements and attributes.
std::string escaped(const std::string& text);

/// An <img> with the picture's bytes in it and a text for those who cannot see it.
std::string embedded_picture(const std::filesystem::path& png, const std::string& alternative);

struct Line {
  std::string name;
  std::vector<double> x, y;
};
/// A line chart as SVG.
std::string line_chart(const std::vector<Line>& lines, const std::string& x_label,
                       const std::string& y_label);
/// Bars of `shares` (0..1), each `bin` wide from 0; the last holds everything beyond.
std::string bar_chart(const std::vector<double>& shares, double bin, const std::string& x_label,
                      const std::string& y_label);

/// The whole page around a body.
std::string page(const std::string& title, const std::string& body);

}  // namespace sanatrix::report

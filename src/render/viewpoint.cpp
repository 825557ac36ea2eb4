// Directions are LPS: +x patient left, +y posterior, +z superior.
#include "render/viewpoint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace sanatrix::render {

Viewpoint viewpoint_of(View view) {
  constexpr double h = 0.70710678118654752;
  constexpr Vec3 superior{0, 0, 1};
  switch (view) {
    case View::Front:
      break;
    case View::LeftOblique:
      return {{h, -h, 0}, superior};
    case View::RightOblique:
      return {{-h, -h, 0}, superior};
    case View::Left:
      return {{1, 0, 0}, superior};
    case View::Right:
      return {{-1, 0, 0}, superior};
    case View::Below:  // as a radiologist sees axial slices: from the feet, anterior up
      return {{0, 0, -1}, {0, -1, 0}};
  }
  return {{0, -1, 0}, superior};
}

Viewpoint viewpoint_of_cut(const Vec3& normal) {
  const Vec3 n = normalised(normal);
  const double x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
  const bool axial = z >= x && z >= y;
  const Vec3 usual = axial ? Vec3{0, 0, -1} : y >= x ? Vec3{0, -1, 0} : Vec3{1, 0, 0};
  const Vec3 towards = dot(n, usual) < 0 ? -1.0 * n : n;
  const Vec3 wanted_up = axial ? Vec3{0, -1, 0} : Vec3{0, 0, 1};
  return {towards, normalised(wanted_up - dot(wanted_up, towards) * towards)};
}

Vec3 to_the_right(const Viewpoint& view) {
  return cross(view.up, view.towards_viewer);
}

std::string orientation_letters(const Vec3& direction) {
  constexpr std::string_view positive = "LPS", negative = "RAI";
  constexpr double visible = 0.38;  // sine of 22.5 degrees: half-way to the next letter
  std::array<std::size_t, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(direction[a]) > std::abs(direction[b]) + 1e-9;
  });
  std::string letters;
  for (const std::size_t axis : order) {
    if (std::abs(direction[axis]) > visible) {
      letters += direction[axis] > 0 ? positive[axis] : negative[axis];
    }
  }
  return letters;
}

std::string side_in_words(const Vec3& direction) {
  return direction[0] > 0 ? "patient's LEFT" : "patient's RIGHT";
}

}  // namespace sanatrix::render

// Landmarks from the front of the body: two peaks towards -y with a cleft between them.
#include "imaging/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.hpp"

namespace sanatrix::imaging {
namespace {

/// Less than this and a cleft or a breast cannot be told from an uneven chest [mm].
constexpr double least_prominence_mm = 12.0;

/// Index j of the most anterior body voxel per column; size[1] where the column is empty.
std::vector<int> skin_front(const LabelImage& labels) {
  const auto [nx, ny, nz] = labels.size;
  std::vector<int> front(static_cast<std::size_t>(nx) * static_cast<std::size_t>(nz), ny);
  std::size_t column = 0;
  for (int k = 0; k < nz; ++k) {
    for (int i = 0; i < nx; ++i, ++column) {
      int j = 0;
      while (j < ny && labels.at(i, j, k) == 0) {
        ++j;
      }
      front[column] = j;
    }
  }
  return front;
}

struct Peak {
  int at;
  double prominence;
};

/// Local maxima of a profile with their topological prominence, most prominent first.
std::vector<Peak> peaks_of(const std::vector<double>& height) {
  const int n = static_cast<int>(height.size());
  std::vector<int> order(height.size());
  std::iota(order.begin(), order.end(), 0);
  const auto h = [&](int i) {
    return height[static_cast<std::size_t>(i)];
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return h(a) > h(b); });
  // Flooding downwards: a peak ends where its island touches a higher one.
  std::vector<int> summit(height.size(), -1);
  std::vector<Peak> peaks;
  const auto end_island = [&](int from, int to, double level) {
    peaks.push_back({from, h(from) - level});
    std::replace(summit.begin(), summit.end(), from, to);
  };
  for (const int i : order) {
    const int left = i > 0 ? summit[static_cast<std::size_t>(i - 1)] : -1;
    const int right = i + 1 < n ? summit[static_cast<std::size_t>(i + 1)] : -1;
    int& mine = summit[static_cast<std::size_t>(i)];
    mine = left >= 0 ? left : right >= 0 ? right : i;
    if (left >= 0 && right >= 0 && left != right) {
      if (h(left) >= h(right)) {
        end_island(right, left, h(i));
      } else {
        end_island(left, right, h(i));
      }
    }
  }
  peaks.push_back({order.front(), h(order.front()) - h(order.back())});
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.prominence > b.prominence; });
  return peaks;
}

/// Columns i of the patient's right and left breast (+x is left).
std::array<int, 2> breast_columns(const LabelImage& labels, const std::vector<int>& front) {
  const auto nx = static_cast<std::size_t>(labels.size[0]);
  std::vector<double> height(nx, -labels.size[1] * labels.spacing_mm[1]);
  for (std::size_t c = 0; c < front.size(); ++c) {
    height[c % nx] = std::max(height[c % nx], -front[c] * labels.spacing_mm[1]);
  }
  const std::vector<Peak> peaks = peaks_of(height);
  if (peaks.size() < 2 || peaks[1].prominence < least_prominence_mm) {
    throw Error(
        Fault::Input,
        fmt::format("labels: two breasts with a cleft of {:.0f} mm or more between them were "
                    "not found; the front of the body has one rise only, at x = {:.0f} mm",
                    least_prominence_mm, labels.position_mm(peaks[0].at, 0, 0)[0]),
        "use a prone MRI that shows both breasts hanging towards anterior, and the sternum");
  }
  return {std::min(peaks[0].at, peaks[1].at), std::max(peaks[0].at, peaks[1].at)};
}

/// The most anterior skin between two columns: mean over everything within 2 mm of the tip.
Vec3 most_anterior(const LabelImage& labels, const std::vector<int>& front, int from, int to) {
  const int nx = labels.size[0];
  const auto at = [&](int i, int k) {
    return front[static_cast<std::size_t>(k) * static_cast<std::size_t>(nx) +
                 static_cast<std::size_t>(i)];
  };
  int tip = labels.size[1];
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = from; i <= to; ++i) {
      tip = std::min(tip, at(i, k));
    }
  }
  const double depth = 2.0 / labels.spacing_mm[1];
  Vec3 sum{};
  double count = 0.0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int i = from; i <= to; ++i) {
      if (at(i, k) <= tip + depth) {
        sum += Vec3{static_cast<double>(i), static_cast<double>(tip), static_cast<double>(k)};
        count += 1.0;
      }
    }
  }
  const Vec3 mean = (1.0 / count) * sum;
  return labels.position_mm(mean[0], mean[1], mean[2]);
}

/// Middle of the cleft half way up its walls, median over the slices around the nipples.
double cleft_middle(const LabelImage& labels, const std::vector<int>& front,
                    const std::array<int, 2>& column, double z_mm) {
  const int centre = static_cast<int>(std::lround(labels.continuous_index({0, 0, z_mm})[2]));
  const int reach = static_cast<int>(std::lround(20.0 / labels.spacing_mm[2]));
  std::vector<double> middle;
  for (int k = std::max(0, centre - reach); k <= std::min(labels.size[2] - 1, centre + reach);
       ++k) {
    const int* row = &front[static_cast<std::size_t>(k) * static_cast<std::size_t>(labels.size[0])];
    const int floor = *std::max_element(row + column[0], row + column[1] + 1);
    const double level = 0.5 * (floor + std::max(row[column[0]], row[column[1]]));
    int low = column[0];
    while (low < column[1] && row[low] <= level) {
      ++low;
    }
    int high = column[1];
    while (high > low && row[high] <= level) {
      --high;
    }
    middle.push_back(0.5 * (low + high));
  }
  std::nth_element(middle.begin(), middle.begin() + static_cast<long>(middle.size() / 2),
                   middle.end());
  return labels.position_mm(middle[middle.size() / 2], 0, 0)[0];
}

/// Centroids of the nipple labels on both sides, when both are there.
bool labelled_nipples(const LabelImage& labels, double midline_x_mm, std::array<Vec3, 2>& nipple) {
  std::array<Vec3, 2> sum{};
  std::array<double, 2> count{};
  std::size_t voxel = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
        if (labels.voxels[voxel] == static_cast<unsigned char>(Label::Nipple)) {
          const Vec3 p = labels.position_mm(i, j, k);
          const std::size_t side = p[0] > midline_x_mm ? 1 : 0;
          sum[side] += p;
          count[side] += 1.0;
        }
      }
    }
  }
  if (count[0] == 0.0 || count[1] == 0.0) {
    return false;
  }
  nipple = {(1.0 / count[0]) * sum[0], (1.0 / count[1]) * sum[1]};
  return true;
}

}  // namespace

Landmarks find_landmarks(const LabelImage& labels) {
  const std::vector<int> front = skin_front(labels);
  const std::array<int, 2> column = breast_columns(labels, front);
  const int between = (column[0] + column[1]) / 2;
  Landmarks marks;
  marks.nipple_mm = {most_anterior(labels, front, 0, between),
                     most_anterior(labels, front, between, labels.size[0] - 1)};
  marks.midline_x_mm =
      cleft_middle(labels, front, column, 0.5 * (marks.nipple_mm[0][2] + marks.nipple_mm[1][2]));
  marks.nipples_from_label = labelled_nipples(labels, marks.midline_x_mm, marks.nipple_mm);
  return marks;
}

}  // namespace sanatrix::imaging

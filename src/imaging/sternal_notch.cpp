// Going up from the nipples the cleft ends on the plain skin of the breastbone. Where a groove
// opens again, between the heads of the collar bones, its floor falls back behind the breastbone's
// edge and turns up along the neck; the notch is where it turns.
#include "imaging/sternal_notch.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double plain_mm = 2.0;         ///< less is no groove: the skin of the breastbone
constexpr double least_groove_mm = 4.0;  ///< a fold of skin may be as deep
constexpr double clear_groove_mm = 8.0;
constexpr double turn_reach_mm = 15.0;  ///< the turn is measured over twice that
constexpr double least_turn_mm = 1.0, clear_turn_mm = 3.0;
/// Of the confidence, when the floor still turns at the last place where that can be measured.
constexpr double unfinished = 0.3;

/// y [mm] of the front of the body over x and z, smoothed; nothing where there is no body.
class Front {
 public:
  explicit Front(const LabelImage& labels) : labels_(labels) {
    y_.size = {labels.size[0], labels.size[2], 1};
    y_.spacing_mm = {labels.spacing_mm[0], labels.spacing_mm[2], 1.0};
    for (int k = 0; k < labels.size[2]; ++k) {
      for (int i = 0; i < labels.size[0]; ++i) {
        int j = 0;
        while (j < labels.size[1] && labels.at(i, j, k) == 0) {
          ++j;
        }
        const bool body = j < labels.size[1];
        y_.voxels.push_back(body ? static_cast<float>(labels.position_mm(i, j, k)[1]) : 0.0F);
        seen_.voxels.push_back(body ? 1.0F : 0.0F);
      }
    }
    constexpr double stairs_mm = 3.0;  // of slices
    seen_.size = y_.size;
    seen_.spacing_mm = y_.spacing_mm;
    smooth(y_, stairs_mm);
    smooth(seen_, stairs_mm);
  }
  [[nodiscard]] std::optional<double> at(int i, int k) const {
    constexpr float mostly = 0.5F;
    if (i < 0 || i >= y_.size[0] || seen_.at(i, k, 0) < mostly) {
      return std::nullopt;
    }
    return static_cast<double>(y_.at(i, k, 0) / seen_.at(i, k, 0));
  }
  [[nodiscard]] int columns(double mm) const {
    return static_cast<int>(std::lround(mm / labels_.spacing_mm[0]));
  }

 private:
  const LabelImage& labels_;
  Image3<float> y_, seen_;
};

/// The deepest skin near the midline of a slice, and how far the lower of its two banks stands
/// before it.
struct Floor {
  int column;
  double y_mm, groove_mm;
};

std::optional<Floor> floor_of(const Front& front, int middle, int k) {
  constexpr double aside_mm = 15.0, bank_from_mm = 10.0, bank_to_mm = 30.0;
  std::optional<Floor> floor;
  for (int i = middle - front.columns(aside_mm); i <= middle + front.columns(aside_mm); ++i) {
    if (const auto y = front.at(i, k); y && (!floor || *y > floor->y_mm)) {
      floor = {i, *y, 0.0};
    }
  }
  if (!floor || std::abs(floor->column - middle) == front.columns(aside_mm)) {
    return floor;  // a groove beside the midline is one of the neck's sides
  }
  floor->groove_mm = 1e9;
  for (const int side : {-1, 1}) {
    double bank = -1e9;
    for (int d = front.columns(bank_from_mm); d <= front.columns(bank_to_mm); ++d) {
      if (const auto y = front.at(floor->column + side * d, k)) {
        bank = std::max(bank, floor->y_mm - *y);
      }
    }
    floor->groove_mm = std::min(floor->groove_mm, bank);
  }
  return floor;
}

/// From a slice upwards, as far as the midline shows a body.
std::vector<Floor> floors_above(const LabelImage& labels, double midline_x_mm, int first) {
  const Front front(labels);
  const auto middle =
      static_cast<int>(std::lround(labels.continuous_index({midline_x_mm, 0, 0})[0]));
  std::vector<Floor> floors;
  for (int k = first; k < labels.size[2]; ++k) {
    const auto floor = floor_of(front, middle, k);
    if (!floor) {
      break;
    }
    floors.push_back(*floor);
  }
  return floors;
}

/// The sharpest turn of a groove's floor, from `from` on, and how far it has fallen off above it.
struct Turn {
  std::size_t at = 0;
  double size_mm = 0.0;
  double finished = 0.0;  ///< 0..1; 1: it has fallen to a half
};

Turn sharpest_turn(const std::vector<Floor>& floors, std::size_t from, std::size_t reach) {
  Turn turn;
  for (std::size_t n = std::max(from, reach); n + reach < floors.size(); ++n) {
    const double size = floors[n].y_mm - 0.5 * (floors[n - reach].y_mm + floors[n + reach].y_mm);
    if (size > turn.size_mm && floors[n].groove_mm > least_groove_mm) {
      turn = {n, size, 0.0};
    } else if (turn.size_mm > least_turn_mm) {
      turn.finished = std::clamp(2.0 * (turn.size_mm - size) / turn.size_mm, turn.finished, 1.0);
      if (turn.finished == 1.0) {
        break;  // what comes above is neck or chin
      }
    }
  }
  return turn;
}

}  // namespace

SkinLandmark find_sternal_notch(const Segmentation& s) {
  SkinLandmark notch{"sternal_notch"};
  const LabelImage& labels = s.labels;
  const double nipples_z = 0.5 * (s.nipple_mm[0][2] + s.nipple_mm[1][2]);
  const int first =
      std::clamp(static_cast<int>(std::lround(labels.continuous_index({0, 0, nipples_z})[2])), 0,
                 labels.size[2] - 1);
  const std::vector<Floor> floors = floors_above(labels, s.midline_x_mm, first);
  const auto plain =
      std::ranges::find_if(floors, [](const Floor& f) { return f.groove_mm < plain_mm; });
  const auto reach =
      static_cast<std::size_t>(std::max(1L, std::lround(turn_reach_mm / labels.spacing_mm[2])));
  const Turn turn = sharpest_turn(floors, static_cast<std::size_t>(plain - floors.begin()), reach);
  if (turn.size_mm > least_turn_mm) {
    const Floor& floor = floors[turn.at];
    notch.at_mm = labels.position_mm(floor.column, 0, first + static_cast<int>(turn.at));
    (*notch.at_mm)[1] = floor.y_mm;
    notch.confidence = std::min(1.0, floor.groove_mm / clear_groove_mm) *
                       std::min(1.0, turn.size_mm / clear_turn_mm) *
                       (unfinished + (1.0 - unfinished) * turn.finished);
    return notch;
  }
  const double above_mm = static_cast<double>(floors.size()) * labels.spacing_mm[2];
  if (plain != floors.end() && floors.back().groove_mm < least_groove_mm) {
    notch.missing = fmt::format(
        "the skin of the midline has no hollow up to the end of the field, {:.0f} mm above the "
        "nipples: the notch lies beyond, or does not show",
        above_mm);
  } else {
    notch.missing = fmt::format(
        "not inside the field, which ends {:.0f} mm above the nipples, {}", above_mm,
        plain == floors.end() ? "between the breasts" : "in the hollow above the breastbone");
  }
  return notch;
}

}  // namespace sanatrix::imaging

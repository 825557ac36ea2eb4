// From loose slices to volumes: sorted by position along the normal, checked for equal spacing,
// missing and repeated slices, shear and mixed orientations. And the choice among volumes.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.hpp"
#include "io/dicom.hpp"

namespace sanatrix::io {
namespace {

constexpr double same_direction = 1e-3;  ///< rounding of direction cosines in headers
constexpr double same_position_mm = 0.01;
constexpr double gap_tolerance = 0.1;  ///< of the usual gap
constexpr double most_shear_mm = 1.0;  ///< over the whole stack

Vec3 normal_of(const DicomSlice& s) {
  return cross(s.row, s.column);
}

bool same_orientation(const DicomSlice& a, const DicomSlice& b) {
  return norm(a.row - b.row) < same_direction && norm(a.column - b.column) < same_direction;
}

/// What is wrong with the geometry of a single slice, or nothing.
std::string slice_defect(const DicomSlice& s) {
  if (!s.has_geometry) {
    return "position, orientation or pixel spacing is missing";
  }
  if (std::abs(norm(s.row) - 1.0) > 1e-2 || std::abs(norm(s.column) - 1.0) > 1e-2 ||
      std::abs(dot(s.row, s.column)) > 1e-2) {
    return "the orientation is not two unit vectors at right angles";
  }
  if (!(s.pixel_mm[0] > 0.0) || !(s.pixel_mm[1] > 0.0)) {
    return "the pixel spacing is not positive";
  }
  return {};
}

/// Checks the distances between sorted slices; fills spacing, warnings and defect.
void check_gaps(DicomVolume& volume, const std::vector<double>& at) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < at.size(); ++i) {
    gaps.push_back(at[i] - at[i - 1]);
    if (gaps.back() < same_position_mm) {
      volume.defect = fmt::format(
          "two slices lie at the same position, {:.2f} mm along the normal (instances {} and {})",
          at[i], volume.slices[i - 1].instance_number, volume.slices[i].instance_number);
      return;
    }
  }
  std::vector<double> sorted = gaps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2),
                   sorted.end());
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (std::abs(gaps[i] - usual) <= gap_tolerance * usual) {
      continue;
    }
    const double missing = gaps[i] / usual - 1.0;
    const bool whole = missing > 0.5 && std::abs(missing - std::round(missing)) < 0.1;
    volume.defect =
        whole ? fmt::format(
                    "{:.0f} slice(s) are missing between {:.2f} and {:.2f} mm along the "
                    "normal (instances {} and {})",
                    missing, at[i], at[i + 1], volume.slices[i].instance_number,
                    volume.slices[i + 1].instance_number)
              : fmt::format(
                    "slices are not evenly spaced: {:.2f} mm between instances {} and {}, "
                    "{:.2f} mm elsewhere",
                    gaps[i], volume.slices[i].instance_number, volume.slices[i + 1].instance_number,
                    usual);
    return;
  }
  volume.spacing_mm[2] = (at.back() - at.front()) / static_cast<double>(gaps.size());
  if (volume.thickness_mm > 0.0 && usual > 1.5 * volume.thickness_mm) {
    volume.warnings.push_back(fmt::format(
        "slices are {:.1f} mm apart but only {:.1f} mm thick: tissue between them is not imaged; "
        "slices may have been left out",
        usual, volume.thickness_mm));
  } else if (usual > 6.0) {
    volume.warnings.push_back(
        fmt::format("slices are {:.1f} mm apart; shapes between them are guessed", usual));
  }
}

/// A slice of our own number that the series has but the folder lacks, at either end.
void check_numbers(DicomVolume& volume) {
  std::vector<int> numbers;
  for (const DicomSlice& s : volume.slices) {
    numbers.push_back(s.instance_number);
  }
  const auto [low, high] = std::minmax_element(numbers.begin(), numbers.end());
  if (*low == 2 || *low == 3) {
    volume.warnings.push_back(fmt::format(
        "instance numbers begin with {}: slices at one end may have been left out", *low));
  }
}

DicomVolume volume_of(std::vector<DicomSlice> slices) {
  DicomVolume volume;
  const DicomSlice& first = slices.front();
  volume.acquisition = first.acquisition;
  volume.size = {first.size[0], first.size[1], static_cast<int>(slices.size())};
  volume.thickness_mm = first.thickness_mm;
  for (const DicomSlice& s : slices) {
    if (volume.defect.empty()) {
      volume.defect = slice_defect(s);
    }
  }
  const Vec3 normal = normal_of(first);
  std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return std::tuple(dot(normal, a.position_mm), a.instance_number, a.frame) <
           std::tuple(dot(normal, b.position_mm), b.instance_number, b.frame);
  });
  volume.slices = std::move(slices);
  const DicomSlice& lowest = volume.slices.front();
  volume.origin_mm = lowest.position_mm;
  volume.spacing_mm = {lowest.pixel_mm[0], lowest.pixel_mm[1], std::max(volume.thickness_mm, 1e-3)};
  for (std::size_t a = 0; a < 3; ++a) {
    volume.direction[a] = {lowest.row[a], lowest.column[a], normal[a]};
  }
  if (!volume.defect.empty() || volume.slices.size() < 2) {
    return volume;
  }
  std::vector<double> at;
  for (const DicomSlice& s : volume.slices) {
    at.push_back(dot(normal, s.position_mm));
    if (std::abs(s.pixel_mm[0] - lowest.pixel_mm[0]) > 1e-3 ||
        std::abs(s.pixel_mm[1] - lowest.pixel_mm[1]) > 1e-3) {
      volume.defect = "the pixel spacing differs between slices";
      return volume;
    }
  }
  check_gaps(volume, at);
  double shear = 0.0;
  for (const DicomSlice& s : volume.slices) {
    const Vec3 along = s.position_mm - lowest.position_mm;
    shear = std::max(shear, norm(along - dot(along, normal) * normal));
  }
  if (volume.defect.empty() && shear > most_shear_mm) {
    volume.defect = fmt::format(
        "slices are shifted sideways by up to {:.1f} mm (tilted acquisition, or slices of another "
        "one)",
        shear);
  }
  check_numbers(volume);
  return volume;
}

/// Slices of one stack by orientation, the most numerous first.
std::vector<std::vector<DicomSlice>> by_orientation(const std::vector<DicomSlice>& slices) {
  std::vector<std::vector<DicomSlice>> groups;
  for (const DicomSlice& s : slices) {
    const auto group =
        std::ranges::find_if(groups, [&](const auto& g) { return same_orientation(g.front(), s); });
    if (group == groups.end()) {
      groups.push_back({s});
    } else {
      group->push_back(s);
    }
  }
  std::ranges::stable_sort(groups,
                           [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

/// Why a volume cannot become a breast model, or nothing.
std::string unfit_because(const DicomVolume& volume) {
  const Acquisition& a = volume.acquisition;
  constexpr int least_slices = 12;
  // Two breasts side by side, from the sternal notch's height to the fold, with the chest wall.
  constexpr Vec3 least_extent_mm{220.0, 80.0, 90.0};
  if (!volume.defect.empty()) {
    return volume.defect;
  }
  const std::string modality = a.modality.text(), position = a.patient_position.text();
  if (modality != "MR") {
    return "it is not an MRI but " + (modality.empty() ? "unnamed" : modality);
  }
  if (a.localizer || volume.size[2] < least_slices) {
    return fmt::format("it is a localizer or has too few slices ({})", volume.size[2]);
  }
  const Vec3 extent = volume.extent_mm();
  for (std::size_t i = 0; i < 3; ++i) {
    if (extent[i] < least_extent_mm[i]) {
      constexpr std::array names{"left-right", "front-back", "head-feet"};
      return fmt::format("it covers only {:.0f} mm {}; both breasts need {:.0f} mm", extent[i],
                         names[i], least_extent_mm[i]);
    }
  }
  if (position == "HFS" || position == "FFS") {
    return "the patient lies supine (" + position + "); a prone examination is needed";
  }
  if (!position.empty() && position != "HFP" && position != "FFP") {
    return "the patient position is " + position + "; a prone examination is needed (HFP or FFP)";
  }
  if (a.derived_kind) {
    return "it is diffusion, or computed from other images (subtraction, projection, phase, map)";
  }
  if (a.fat_suppressed) {
    return "fat is suppressed; fat and gland are told apart in images without suppression";
  }
  return {};
}

}  // namespace

Vec3 DicomVolume::extent_mm() const {
  Vec3 extent{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      extent[a] += std::abs(direction[a][b]) * spacing_mm[b] * size[b];
    }
  }
  return extent;
}

std::string DicomVolume::plane() const {
  std::size_t main = 0;
  for (std::size_t a = 1; a < 3; ++a) {
    main = std::abs(direction[a][2]) > std::abs(direction[main][2]) ? a : main;
  }
  constexpr std::array names{"sagittal", "coronal", "axial"};
  const bool oblique = std::abs(direction[main][2]) < 0.999;
  return (oblique ? "oblique " : "") + std::string(names[main]);
}

std::vector<DicomVolume> assemble_volumes(const std::vector<DicomSlice>& slices) {
  std::map<std::pair<int, int>, std::vector<DicomSlice>> stacks;
  for (const DicomSlice& s : slices) {
    stacks[{s.acquisition.series_number, s.stack}].push_back(s);
  }
  std::vector<DicomVolume> volumes;
  for (const auto& [key, stack] : stacks) {
    const auto groups = by_orientation(stack);
    for (const auto& group : groups) {
      DicomVolume& volume = volumes.emplace_back(volume_of(group));
      volume.index = static_cast<int>(volumes.size());
      // A few slices that do not belong to a long stack are a mix-up, not a second view.
      // Gaps in what is left are its consequence.
      if (&group == &groups.front() && groups.size() > 1 && group.size() * 5 > stack.size() * 4) {
        volume.defect = fmt::format("{} of {} slices have another orientation",
                                    stack.size() - group.size(), stack.size());
      }
      volume.unfit = unfit_because(volume);
    }
  }
  return volumes;
}

const DicomVolume& choose_volume(const DicomFolder& folder, int series) {
  if (series != 0) {
    for (const DicomVolume& volume : folder.volumes) {
      if (volume.index == series) {
        require(volume.defect.empty(), "series {} cannot be used: {}", series, volume.defect);
        require(volume.size[2] >= 2, "series {} has one slice only", series);
        return volume;
      }
    }
    throw Error(
        Fault::Input,
        fmt::format("there is no series {} in the list of {}", series, folder.volumes.size()),
        "`sanatrix inspect` lists what is there");
  }
  const auto rank = [](const DicomVolume& v) {
    const Acquisition& a = v.acquisition;
    const int weighting = a.weighting == Weighting::T1 ? 0 : a.weighting == Weighting::T2 ? 1 : 2;
    return std::tuple(weighting, a.contrast_agent, !v.plane().ends_with("axial"),
                      v.spacing_mm[0] * v.spacing_mm[1] * v.spacing_mm[2], v.index);
  };
  const DicomVolume* best = nullptr;
  std::string reasons;
  for (const DicomVolume& volume : folder.volumes) {
    if (volume.unfit.empty() && (best == nullptr || rank(volume) < rank(*best))) {
      best = &volume;
    }
    reasons +=
        fmt::format("{}series {}: {}", reasons.empty() ? "" : "; ", volume.index, volume.unfit);
  }
  if (best == nullptr) {
    throw Error(Fault::Input, "no series is fit for a breast model: " + reasons,
                "give a prone, bilateral, non-fat-suppressed T1 or T2 MRI, or choose one with "
                "--series");
  }
  for (const DicomVolume& volume : folder.volumes) {
    if (volume.slices[0].patient != best->slices[0].patient) {
      throw Error(
          Fault::Input,
          fmt::format("series {} and {} are of different patients", best->index, volume.index),
          "give the folder of one patient, or choose a series with --series");
    }
  }
  return *best;
}

}  // namespace sanatrix::io

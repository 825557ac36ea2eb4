// Coarse search over rotations, then robust point-to-plane ICP on ever more points.
#include "outcome/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

constexpr std::size_t most_modes = 3;

/// Vertices of the patient's skin with what they weigh.
struct Source {
  std::vector<Vec3> points, normals;
  std::vector<std::array<Vec3, most_modes>> modes;  ///< zero beyond `mode_count`
  std::vector<double> weight;
  std::size_t mode_count = 0;
};

/// About `count` vertices, evenly over the area, weights as given.
Source sample(const StandingSkin& skin, std::span<const double> weight, std::size_t count,
              std::size_t mode_count) {
  const TriMesh& patient = skin.surface;
  const std::vector<Vec3> normals = vertex_normals(patient);
  const std::vector<double> areas = vertex_areas(patient);
  double total = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    total += areas[v];
  }
  Source source;
  source.mode_count = mode_count;
  const double step = total / static_cast<double>(count);
  double due = 0.5 * step;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    due -= areas[v];
    if (due <= 0) {
      source.points.push_back(patient.points[v]);
      source.normals.push_back(normals[v]);
      auto& modes = source.modes.emplace_back();
      for (std::size_t m = 0; m < mode_count; ++m) {
        modes[m] = skin.modes[m][v];
      }
      const double stands_for = areas.size() <= count ? areas[v] : step;
      source.weight.push_back(weight[v] * stands_for);
      due += step * std::ceil(-due / step + 1e-9);
    }
  }
  return source;
}

Vec3 mean_normal(const TriMesh& surface, Vec3& centre) {
  Vec3 sum{};
  double total = 0;
  centre = {};
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3& p = surface.points[static_cast<std::size_t>(a)];
    const Vec3& q = surface.points[static_cast<std::size_t>(b)];
    const Vec3& r = surface.points[static_cast<std::size_t>(c)];
    const Vec3 n = 0.5 * cross(q - p, r - p);
    sum += n;
    total += norm(n);
    centre += (norm(n) / 3) * (p + q + r);
  }
  centre = (1 / total) * centre;
  return (1 / total) * sum;
}

Mat3 plain(const Eigen::Matrix3d& m) {
  Mat3 r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      r[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = m(i, j);
    }
  }
  return r;
}

Mat3 rotation_about(const Vec3& axis, double angle) {
  return plain(
      Eigen::AngleAxisd(angle, Eigen::Vector3d(axis[0], axis[1], axis[2])).toRotationMatrix());
}

/// The shortest turn from one unit vector to another.
Mat3 rotation_between(const Vec3& from, const Vec3& to) {
  const Vec3 axis = cross(from, to);
  const double sine = norm(axis), cosine = dot(from, to);
  if (sine < 1e-9) {
    const Vec3 other = std::abs(from[0]) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    return cosine > 0 ? identity3
                      : rotation_about(normalised(cross(from, other)), std::numbers::pi);
  }
  return rotation_about((1 / sine) * axis, std::atan2(sine, cosine));
}

constexpr double far_m = 0.03;  ///< farther than this is equally bad

struct Pair {
  Vec3 p, q, n;  ///< moved source point, its closest scan point, the scan's normal there
  std::array<Vec3, most_modes> modes;  ///< turned into the scan's frame
  double distance, weight;
};

struct Candidate {
  Rigid to_scan;
  std::array<double, most_modes> shares{};
  double score = far_m;
};

/// One step's correspondences; points without counterpart (hole, border, other side) are left out.
std::vector<Pair> pair_up(const Source& source, const ScanTarget& target,
                          const Candidate& candidate, double least_cosine, double* score) {
  const Rigid& to_scan = candidate.to_scan;
  std::vector<Pair> pairs;
  double bad = 0, total = 0;
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    std::array<Vec3, most_modes> modes{};
    Vec3 p = to_scan(source.points[i]);
    for (std::size_t m = 0; m < source.mode_count; ++m) {
      modes[m] = to_scan.rotation * source.modes[i][m];
      p += candidate.shares[m] * modes[m];
    }
    const auto hit = target.closest(p);
    const bool fits =
        !hit.on_border && dot(to_scan.rotation * source.normals[i], hit.normal) > least_cosine;
    if (fits) {
      pairs.push_back({p, hit.point, hit.normal, modes, hit.distance, source.weight[i]});
    }
    bad += source.weight[i] * (fits ? std::min(hit.distance, far_m) : far_m);
    total += source.weight[i];
  }
  if (score != nullptr) {
    *score = bad / total;
  }
  return pairs;
}

double weighted_median(std::vector<Pair>& pairs) {
  std::ranges::sort(pairs, {}, &Pair::distance);
  double total = 0, below = 0;
  for (const Pair& pair : pairs) {
    total += pair.weight;
  }
  for (const Pair& pair : pairs) {
    below += pair.weight;
    if (below >= 0.5 * total) {
      return pair.distance;
    }
  }
  return pairs.empty() ? far_m : pairs.back().distance;
}

/// The small motion, and change of the modes' shares, after which the pairs' distances along the
/// normals are least; Tukey's biweight forgets what is farther than `reach`. Returns how much
/// moved.
double step(Candidate& candidate, std::span<const Pair> pairs, std::size_t mode_count,
            double reach) {
  constexpr int most = 6 + static_cast<int>(most_modes);
  using System = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
  const int size = 6 + static_cast<int>(mode_count);
  System a = System::Zero(size, size);
  Vector b = Vector::Zero(size), row(size);
  Vec3 centre{};
  double total = 0;
  for (const Pair& pair : pairs) {
    centre += pair.weight * pair.p;
    total += pair.weight;
  }
  centre = (1 / total) * centre;
  for (const Pair& pair : pairs) {
    const double far = pair.distance / reach;
    if (far >= 1) {
      continue;
    }
    const double weight = pair.weight * (1 - far * far) * (1 - far * far);
    const Vec3 arm = cross(pair.p - centre, pair.n);
    for (int k = 0; k < 3; ++k) {
      row[k] = arm[static_cast<std::size_t>(k)];
      row[3 + k] = pair.n[static_cast<std::size_t>(k)];
    }
    for (int m = 6; m < size; ++m) {
      row[m] = dot(pair.n, pair.modes[static_cast<std::size_t>(m - 6)]);
    }
    a.noalias() += weight * row * row.transpose();
    b.noalias() += weight * dot(pair.n, pair.q - pair.p) * row;
  }
  // What the shape leaves open (sliding along a cylinder) stays where it is.
  const double lever = 0.1;  // [m]
  const double trace = a(3, 3) + a(4, 4) + a(5, 5);
  for (int k = 0; k < size; ++k) {
    a(k, k) +=
        k < 6 ? 1e-6 * trace * (k < 3 ? lever * lever : 1.0) + 1e-300 : 1e-6 * a(k, k) + 1e-300;
  }
  const Vector x = a.ldlt().solve(b);
  const Vec3 axis{x[0], x[1], x[2]}, shift{x[3], x[4], x[5]};
  const double angle = norm(axis);
  Rigid move;
  move.rotation = angle > 0 ? rotation_about((1 / angle) * axis, angle) : identity3;
  move.shift = centre + shift - move.rotation * centre;
  candidate.to_scan = move * candidate.to_scan;
  for (std::size_t m = 0; m < mode_count; ++m) {
    candidate.shares[m] = std::clamp(candidate.shares[m] + x[6 + static_cast<int>(m)], -1.5, 1.5);
  }
  return std::max(angle * lever, norm(shift));
}

/// Robust ICP; the reach shrinks from far_m to a few medians.
void refine(Candidate& candidate, const Source& source, const ScanTarget& target, int iterations,
            double least_cosine) {
  constexpr double least_reach = 0.003;
  for (int i = 0; i < iterations; ++i) {
    std::vector<Pair> pairs = pair_up(source, target, candidate, least_cosine, &candidate.score);
    if (pairs.size() < 20) {
      candidate.score = far_m;
      return;
    }
    const double reach = std::max(least_reach, 4.7 * 1.48 * weighted_median(pairs));
    if (step(candidate, pairs, source.mode_count, reach) < 1e-6) {
      break;
    }
  }
  pair_up(source, target, candidate, least_cosine, &candidate.score);
}

/// Rotations that bring the front of the patient to the front of the scan, turned about it; all
/// directions when the scan goes round the body and has no front.
std::vector<Candidate> starts(const TriMesh& patient, const TriMesh& scan) {
  Vec3 patient_centre, scan_centre;
  const Vec3 front = normalised(mean_normal(patient, patient_centre));
  const Vec3 scan_front = mean_normal(scan, scan_centre);
  std::vector<Vec3> fronts;
  if (norm(scan_front) > 0.2) {
    fronts.push_back(normalised(scan_front));
  } else {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (x != 0 || y != 0 || z != 0) {
            fronts.push_back(normalised({1.0 * x, 1.0 * y, 1.0 * z}));
          }
        }
      }
    }
  }
  constexpr int turns = 24;
  std::vector<Candidate> candidates;
  for (const Vec3& towards : fronts) {
    for (int turn = 0; turn < turns; ++turn) {
      const Mat3 rotation = rotation_about(towards, 2 * std::numbers::pi * turn / turns) *
                            rotation_between(front, towards);
      // The scan may reach farther up or down than the image.
      for (const double up : {-0.08, 0.0, 0.08}) {
        const Vec3 from = patient_centre + Vec3{0, 0, up};
        candidates.push_back({{rotation, scan_centre - rotation * from}, {}, far_m});
      }
    }
  }
  return candidates;
}

void keep_best(std::vector<Candidate>& candidates, std::size_t count) {
  std::ranges::sort(candidates, {}, &Candidate::score);
  candidates.resize(std::min(candidates.size(), count));
}

Candidate search(const StandingSkin& patient, const ScanTarget& target) {
  const std::vector<double> even(patient.surface.points.size(), 1.0);
  const Source few = sample(patient, even, 200, 0), more = sample(patient, even, 600, 0);
  std::vector<Candidate> candidates = starts(patient.surface, target.surface());
  for (Candidate& candidate : candidates) {
    refine(candidate, few, target, 6, 0.0);
  }
  keep_best(candidates, 6);
  for (Candidate& candidate : candidates) {
    refine(candidate, more, target, 20, 0.5);
  }
  keep_best(candidates, 1);
  return candidates.front();
}

Alignment measure(const Candidate& candidate, const Source& source, const ScanTarget& target) {
  std::vector<Pair> pairs = pair_up(source, target, candidate, 0.5, nullptr);
  Alignment result{.to_patient = inverse(candidate.to_scan), .median_m = weighted_median(pairs)};
  result.mode_shares.assign(candidate.shares.begin(),
                            candidate.shares.begin() + static_cast<long>(source.mode_count));
  double covered = 0, total = 0, squares = 0, used = 0;
  for (const double weight : source.weight) {
    total += weight;
  }
  for (const Pair& pair : pairs) {  // ascending
    covered += pair.distance < far_m ? pair.weight : 0.0;
  }
  for (const Pair& pair : pairs) {
    if (used <= 0.9 * covered) {
      squares += pair.weight * pair.distance * pair.distance;
      used += pair.weight;
    }
  }
  result.rms_m = used > 0 ? std::sqrt(squares / used) : far_m;
  result.overlap = total > 0 ? covered / total : 0.0;
  return result;
}

}  // namespace

namespace {

Alignment align_from(Candidate start, const StandingSkin& patient, const ScanTarget& target) {
  const Source source = sample(patient, patient.trust, 3000, patient.modes.size());
  refine(start, source, target, 100, 0.5);
  return measure(start, source, target);
}

}  // namespace

Alignment align_freely(const StandingSkin& patient, const TriMesh& scan, const Rigid& start) {
  return align_from({inverse(start), {}, far_m}, patient, ScanTarget(scan));
}

Alignment align(const StandingSkin& patient, const TriMesh& scan,
                const std::optional<Rigid>& start) {
  ensure(
      patient.trust.size() == patient.surface.points.size() && patient.modes.size() <= most_modes,
      "{} weights for {} vertices, {} modes", patient.trust.size(), patient.surface.points.size(),
      patient.modes.size());
  constexpr double search_edge_m = 0.006;
  const Candidate first = start ? Candidate{inverse(*start), {}, far_m}
                                : search(patient, ScanTarget(coarsened(scan, search_edge_m)));
  Alignment found = align_from(first, patient, ScanTarget(scan));
  // A scan of the same woman agrees within a few millimetres where skin hardly moves.
  constexpr double worst_median_m = 0.008, least_overlap = 0.5;
  if (found.median_m > worst_median_m || found.overlap < least_overlap) {
    throw Error(Fault::Input,
                fmt::format("the scan cannot be laid onto the patient: it covers {:.0f} % of her "
                            "skin and lies {:.1f} mm from it in the median (needed: {:.0f} %, "
                            "{:.0f} mm)",
                            100 * found.overlap, 1e3 * found.median_m, 100 * least_overlap,
                            1e3 * worst_median_m),
                "check that it is a scan of this patient's bare trunk, and its unit, or give "
                "--scan-landmarks");
  }
  return found;
}

Rigid match_landmarks(std::span<const Vec3> scan, std::span<const Vec3> patient) {
  require(scan.size() == patient.size() && scan.size() >= 3,
          "{} landmarks on the scan match {} of the patient; three pairs are needed", scan.size(),
          patient.size());
  const double share = 1.0 / static_cast<double>(scan.size());
  Vec3 scan_centre{}, patient_centre{};
  for (std::size_t i = 0; i < scan.size(); ++i) {
    scan_centre += share * scan[i];
    patient_centre += share * patient[i];
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3 from = scan[i] - scan_centre, to = patient[i] - patient_centre;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        covariance(r, c) += to[static_cast<std::size_t>(r)] * from[static_cast<std::size_t>(c)];
      }
    }
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  require(svd.singularValues()[1] > 1e-6 * svd.singularValues()[0],
          "the landmarks of the scan lie on one line; no rotation follows from them");
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  Rigid move;
  move.rotation = plain(svd.matrixU() * flip * svd.matrixV().transpose());
  move.shift = patient_centre - move.rotation * scan_centre;
  return move;
}

}  // namespace sanatrix::outcome

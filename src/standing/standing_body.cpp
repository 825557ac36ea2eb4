#include "standing/standing_body.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/image_filters.hpp"
#include "standing/arms.hpp"
#include "standing/closed_body.hpp"

namespace sanatrix::standing {
namespace {

constexpr double map_spacing_mm = 4.0;   ///< as meshing looks for the breasts
constexpr double body_spacing_mm = 2.0;  ///< of the distance to the skin; smooth between
/// Beyond the breasts; the mesh ends before (meshing/anatomy.cpp).
constexpr double beyond_mm = 45.0;
const double above_mm = meshing::standing_above_mm + 20.0;
constexpr double behind_rim_mm = 60.0;
constexpr double skin_mm = 2.0;
constexpr double muscle_mm = 12.0;
/// Neck and hips do not belong to the model.
constexpr std::array<double, 2> trunk_half_mm{230.0, 240.0};

/// The scan around the breasts.
TriMesh trunk_of(const TriMesh& skin) {
  TriMesh trunk{skin.points, {}};
  for (const auto& t : skin.triangles) {
    const bool near = std::ranges::all_of(t, [&](int v) {
      const Vec3& p = skin.points[static_cast<std::size_t>(v)];
      return std::abs(1e3 * p[0]) < trunk_half_mm[0] && std::abs(1e3 * p[2]) < trunk_half_mm[1];
    });
    if (near) {
      trunk.triangles.push_back(t);
    }
  }
  return trunk;
}

const char* name_of(std::size_t side) {
  return side == 0 ? "right" : "left";
}

/// Refuses scans that do not show enough of a breast; returns the share that is not seen.
double check_coverage(const FrontMap& front, const meshing::BreastMap& breasts) {
  constexpr double most_unseen = 0.4, largest_hole_mm = 20.0;
  const std::vector<double> to_skin = frontal_distance(front.skin_y, front.seen);
  const std::vector<bool> holes = front.holes();
  std::array<double, 2> all{}, unseen{};
  for (std::size_t c = 0; c < holes.size(); ++c) {
    if (breasts.side[c] == 0) {
      continue;
    }
    const std::size_t side = breasts.side[c] < 0 ? 0 : 1;
    all[side] += 1;
    unseen[side] += front.seen[c] ? 0 : 1;
    if (holes[c] && to_skin[c] > largest_hole_mm) {
      throw Error(Fault::Input,
                  fmt::format("the scan has a hole over the {} breast that is more than {:.0f} mm "
                              "wide",
                              name_of(side), 2 * largest_hole_mm),
                  "scan the patient again from more directions, or close the hole by hand");
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (unseen[side] > most_unseen * all[side]) {
      throw Error(Fault::Input,
                  fmt::format("the scan shows only {:.0f} % of the {} breast",
                              100 * (1 - unseen[side] / all[side]), name_of(side)),
                  "give a scan from the collar bones to below the folds, and round to the flanks");
    }
  }
  return (unseen[0] + unseen[1]) / (all[0] + all[1]);
}

/// A wall or a chair behind the patient is scanned as part of her.
void check_size(const std::array<double, 2>& breast_cm3) {
  constexpr double most_cm3 = 3000.0;  // twice where gigantomastia begins
  for (std::size_t side = 0; side < 2; ++side) {
    if (breast_cm3[side] > most_cm3) {
      throw Error(Fault::Input,
                  fmt::format("what would be the {} breast has {:.0f} cm3", name_of(side),
                              breast_cm3[side]),
                  "cut off what is not the patient: a wall, a chair, clothes");
    }
  }
}

/// An arm that is pressed against a breast would be taken for its end.
void check_arms(const std::array<double, 2>& armpit_mm, const std::array<Vec3, 2>& nipple_mm) {
  constexpr double least_mm = 35.0;  // breasts reach farther outwards from their nipple
  for (std::size_t side = 0; side < 2; ++side) {
    const double beside = std::abs(armpit_mm[side] - nipple_mm[side][0]);
    if (beside < least_mm) {
      throw Error(Fault::Input,
                  fmt::format("an arm lies {:.0f} mm beside the {} nipple, on the breast", beside,
                              name_of(side)),
                  "scan the patient with her arms held away, or cut the arms off the scan");
    }
  }
}

/// Beyond the scan's ends nothing is known, and beyond the armpits are the arms: no breast is
/// there.
void bound(const FrontMap& front, const std::array<double, 2>& armpit_mm,
           meshing::BreastMap& breasts) {
  const std::vector<bool> holes = front.holes();
  for (std::size_t c = 0; c < holes.size(); ++c) {
    const auto column = static_cast<int>(c % static_cast<std::size_t>(front.skin_y.size[0]));
    const double x = front.skin_y.origin_mm[0] + column * front.skin_y.spacing_mm;
    if ((!front.seen[c] && !holes[c]) || x < armpit_mm[0] || x > armpit_mm[1]) {
      breasts.side[c] = 0;
    }
  }
}

/// z [mm] between which most of the trunk's width was scanned.
std::array<double, 2> seen_heights(const FrontMap& front) {
  const meshing::ColumnMap& map = front.skin_y;
  std::vector<int> seen(static_cast<std::size_t>(map.size[1]), 0);
  for (int k = 0; k < map.size[1]; ++k) {
    for (int i = 0; i < map.size[0]; ++i) {
      seen[static_cast<std::size_t>(k)] += front.seen[map.index(i, k)] ? 1 : 0;
    }
  }
  const int enough = *std::ranges::max_element(seen) / 2;
  const auto is_enough = [&](int n) {
    return n >= enough;
  };
  const auto first = std::ranges::find_if(seen, is_enough) - seen.begin();
  const auto last = std::find_if(seen.rbegin(), seen.rend(), is_enough).base() - seen.begin() - 1;
  const auto height = [&](auto k) {
    return map.origin_mm[1] + static_cast<double>(k) * map.spacing_mm;
  };
  return {height(first), height(last)};
}

LabelImage grid_around(const meshing::BreastMap& breasts, const FrontMap& front,
                       const std::array<double, 2>& armpit_mm, double spacing_mm) {
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  const meshing::ColumnMap& map = front.skin_y;
  for (int k = 0; k < map.size[1]; ++k) {
    for (int i = 0; i < map.size[0]; ++i) {
      if (const std::size_t c = map.index(i, k); breasts.side[c] != 0) {
        const Vec3 p{map.origin_mm[0] + i * map.spacing_mm, map.value[c],
                     map.origin_mm[1] + k * map.spacing_mm};
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], p[a]);
          high[a] = std::max(high[a], p[a]);
        }
        high[1] = std::max(high[1], breasts.base.value[c]);
      }
    }
  }
  low[0] = std::max(low[0] - beyond_mm, armpit_mm[0]);
  high[0] = std::min(high[0] + beyond_mm, armpit_mm[1]);
  // Not where the scan ends: what is made up beyond its rim is good for holes, not for a trunk.
  const auto [lowest, highest] = seen_heights(front);
  constexpr double frayed_mm = 8.0;  // rims are rough, and the skin beyond them is made up
  low[2] = std::max(low[2] - beyond_mm, lowest + frayed_mm);
  high[2] = std::min(high[2] + above_mm, highest - frayed_mm);
  LabelImage grid{.spacing_mm = {spacing_mm, spacing_mm, spacing_mm}, .voxels = {}};
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    constexpr Vec3 before{0.0, 10.0, 0.0}, behind{0.0, behind_rim_mm, 0.0};
    grid.origin_mm[a] = low[a] - before[a];
    const double end = high[a] + behind[a];
    grid.size[a] = 1 + static_cast<int>((end - grid.origin_mm[a]) / spacing_mm);
    count *= static_cast<std::size_t>(grid.size[a]);
  }
  grid.voxels.assign(count, 0);
  return grid;
}

Image3<float> body_on(const LabelImage& labels, const TriMesh& skin) {
  Image3<float> body{.size = {},
                     .spacing_mm = {body_spacing_mm, body_spacing_mm, body_spacing_mm},
                     .origin_mm = labels.origin_mm,
                     .voxels = {}};
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    body.size[a] =
        2 + static_cast<int>((labels.size[a] - 1) * labels.spacing_mm[a] / body_spacing_mm);
    count *= static_cast<std::size_t>(body.size[a]);
  }
  body.voxels.resize(count);
  measure_body(skin, body);
  return body;
}

/// Depth [mm] below the skin of the trunk without breasts, on the body's grid.
Image3<float> depth_in_trunk(const Image3<float>& body, const meshing::ColumnMap& base) {
  Mask trunk = image_like<unsigned char>(body);
  std::size_t voxel = 0;
  for (int k = 0; k < body.size[2]; ++k) {
    for (int j = 0; j < body.size[1]; ++j) {
      for (int i = 0; i < body.size[0]; ++i, ++voxel) {
        const Vec3 p = body.position_mm(i, j, k);
        const bool inside = body.voxels[voxel] < 0 && p[1] > base.value[base.nearest(p[0], p[2])];
        trunk.voxels[voxel] = inside ? 1 : 0;
      }
    }
  }
  Image3<float> depth = signed_distance(trunk, {true, true, true}, 40.0);
  smooth(depth, 4.0);  // takes the stairs of columns and voxels off
  for (float& d : depth.voxels) {
    d = -d;
  }
  return depth;
}

class Painter {
 public:
  Painter(const TriMesh& skin, const std::array<Vec3, 2>& nipple, const BodyOptions& options)
      : options_(options), nipple_mm_{1e3 * nipple[0], 1e3 * nipple[1]}, skin_(trunk_of(skin)) {
    require(!skin_.triangles.empty(), "nothing of the scan lies around the nipples");
  }

  StandingBody run(const Context& ctx) {
    front_ = front_map(skin_, window_of(skin_, 2 * map_spacing_mm), map_spacing_mm);
    breasts_ = meshing::map_breasts(front_.skin_y, front_.skin_y,
                                    {.midline_x_mm = 0.0,
                                     .nipple_mm = nipple_mm_,
                                     .ball = meshing::standing_ball,
                                     .breast_reach_mm = meshing::standing_reach_mm,
                                     .least_saddle = meshing::standing_least_saddle});
    const std::array<double, 2> armpit_mm = armpits(front_, nipple_mm_);
    check_arms(armpit_mm, nipple_mm_);
    bound(front_, armpit_mm, breasts_);
    StandingBody result;
    result.unseen_share = check_coverage(front_, breasts_);
    ctx.at(0.1, "closing the skin");
    LabelImage labels = grid_around(breasts_, front_, armpit_mm, options_.spacing_mm);
    body_ = body_on(labels, skin_);
    ctx.at(0.5, "chest wall");
    depth_ = depth_in_trunk(body_, trunk_without_breasts(front_, breasts_));
    ctx.at(0.7, "labels");
    result.side = breasts_.side;
    paint(std::move(labels), result);
    check_size(result.breast_cm3);
    find_wall(result);
    return result;
  }

 private:
  [[nodiscard]] signed char side_at(const Vec3& p) const {
    return breasts_.side[breasts_.base.nearest(p[0], p[2])];
  }

  void paint(LabelImage labels, StandingBody& result) const {
    imaging::Segmentation& out = result.segmentation;
    out.fibroglandular = image_like<float>(labels);
    std::array<double, 2> area_mm2{}, voxels{};
    std::size_t voxel = 0;
    for (int k = 0; k < labels.size[2]; ++k) {
      for (int j = 0; j < labels.size[1]; ++j) {
        for (int i = 0; i < labels.size[0]; ++i, ++voxel) {
          const Vec3 p = labels.position_mm(i, j, k);
          const double outside = sample(body_, p);
          if (outside > 0) {
            continue;
          }
          const double behind = sample(depth_, p) - options_.wall_depth_mm;
          using enum Label;
          Label label = Adipose;
          if (behind > 0) {
            label = behind < muscle_mm ? Muscle : Organ;
          } else if (outside > -skin_mm) {
            label = Skin;
          }
          labels.voxels[voxel] = static_cast<unsigned char>(label);
          if (const signed char side = side_at(p); side != 0 && behind <= 0) {
            out.fibroglandular.voxels[voxel] = static_cast<float>(options_.gland_share);
            voxels[side < 0 ? 0 : 1] += 1;
          }
        }
      }
    }
    for (const signed char side : breasts_.side) {
      if (side != 0) {
        area_mm2[side < 0 ? 0 : 1] += map_spacing_mm * map_spacing_mm;
      }
    }
    for (std::size_t s = 0; s < 2; ++s) {
      result.breast_cm3[s] = voxels[s] * labels.voxel_volume_mm3() * 1e-3;
      result.breast_doubt_cm3[s] = area_mm2[s] * wall_offset_doubt_mm * 1e-3;
    }
    out.labels = std::move(labels);
    out.midline_x_mm = 0.0;
    out.nipple_mm = nipple_mm_;
    out.nipples_from_label = true;
  }

  void find_wall(StandingBody& result) const {
    result.wall_y = breasts_.base;
    const LabelImage& labels = result.segmentation.labels;
    for (int k = 0; k < result.wall_y.size[1]; ++k) {
      for (int i = 0; i < result.wall_y.size[0]; ++i) {
        Vec3 p{result.wall_y.origin_mm[0] + i * map_spacing_mm, labels.origin_mm[1],
               result.wall_y.origin_mm[1] + k * map_spacing_mm};
        const double end = labels.position_mm(0, labels.size[1] - 1, 0)[1];
        while (p[1] < end && sample(depth_, p) < options_.wall_depth_mm) {
          p[1] += 0.5;
        }
        result.wall_y.at(i, k) = p[1];
      }
    }
  }

  BodyOptions options_;
  std::array<Vec3, 2> nipple_mm_{};
  TriMesh skin_;
  FrontMap front_;
  meshing::BreastMap breasts_;
  Image3<float> body_, depth_;
};

}  // namespace

StandingBody build_body(const TriMesh& skin, const std::array<Vec3, 2>& nipple,
                        const BodyOptions& options, const Context& ctx) {
  return Painter(skin, nipple, options).run(ctx);
}

}  // namespace sanatrix::standing

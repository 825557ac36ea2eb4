// Step G: what the surgeon decides and what it removes. Pure geometry in one frame.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "surgery/anatomy.hpp"

namespace sanatrix::surgery {

enum class Side { Right, Left };
/// The pose in which the plan's coordinates are given: that of the image (Prone), of the scan when
/// there is no image (Upright), or the operating table.
enum class Frame { Prone, Supine, Upright };

/// A segment (wedge) of the breast: a sector around the nipple, seen along the axis, with the
/// tumour's centre on its middle line.
struct Segment {
  Vec3 apex{};                  ///< the nipple [m]
  std::optional<double> angle;  ///< between its sides [rad]; default: the margin is kept at both
  std::optional<double> from;   ///< distance from the apex at which it begins [m]; default as above
  std::optional<double> to;     ///< and ends [m]
};

struct Plan {
  Side side = Side::Left;
  Frame frame = Frame::Prone;
  std::string quadrant;          ///< free text of the surgeon, may be empty
  Vec3 tumour_centre{};          ///< [m], LPS
  double tumour_radius = 0.0;    ///< [m]
  double margin = 0.010;         ///< [m]
  double clearance = 0.005;      ///< caps stay this far from skin and chest wall [m]
  std::optional<double> radius;  ///< cylinder radius [m]; default tumour_radius + margin
  std::optional<Vec3> axis;      ///< towards the skin; default the chest-wall normal
  /// Closed curve on the skin, not closed by a repeated point: what is removed is what lies behind
  /// it along the axis, instead of a cylinder. Empty, or at least three points. [m]
  std::vector<Vec3> outline;
  std::optional<Segment> segment;            ///< instead of a cylinder; never beside an outline
  std::vector<std::vector<Vec3>> incisions;  ///< polylines on the skin, may be empty [m]
  std::string document = "{}";  ///< JSON it was read from: write_plan keeps what it does not know
};

/// Reads the JSON of shared plans (coordinates in LPS mm; docs/user/plan.md). Error{Input} names
/// the key that is missing or wrong; left/right contradictions between `operated_side`, tumour
/// position and midline are errors.
Plan read_plan(const std::string& json_text, const std::string& file_name);
/// The same document with the fields of `plan`, so that a changed plan can be stored.
std::string write_plan(const Plan& plan);
/// Changes one field by name ("margin_mm", "radius_mm", "clearance_mm", "tumour_radius_mm");
/// Error{Usage} for unknown names, Error{Input} for values out of range.
void set_plan_value(Plan& plan, const std::string& key, const std::string& value);

/// How finely volumes are measured: Full for results; Live while somebody drags a plan, 1 % off at
/// most and several times faster.
enum class Detail { Full, Live };

/// The removed volume: a cylinder, sector or outline along the axis, with rounded caps that stay
/// `clearance` from skin and chest wall, as an implicit function. Always the one connected piece
/// that holds the tumour. docs/theory/surgery.md
class Resection {
 public:
  /// The anatomy in the pose of plan.frame. Error{Input} when the tumour is outside the model, on
  /// the wrong side of the midline, or nothing is left between the two clearances.
  Resection(const Plan& plan, std::shared_ptr<const Anatomy> anatomy, Detail detail = Detail::Full);
  Resection(const Plan& plan, const TetMesh& mesh, std::span<const Vec3> points, double midline_x_m,
            Detail detail = Detail::Full);
  /// Negative inside; |value| is close to the distance near the surface [m].
  [[nodiscard]] double signed_distance(const Vec3& p) const;
  /// Share of a tetrahedron that is removed, 0..1.
  [[nodiscard]] double volume_fraction(const std::array<Vec3, 4>& corners) const;
  /// The axis of the shape: chest_point() to skin_point() with radius() contains all of it but
  /// what slanting skin adds (for mesh focus and search).
  [[nodiscard]] Vec3 axis_towards_skin() const { return axis_; }
  [[nodiscard]] Vec3 chest_point() const { return chest_; }
  [[nodiscard]] Vec3 skin_point() const { return skin_; }
  [[nodiscard]] double radius() const { return radius_; }
  /// The exact shape inside the body by fine sampling (volume error well below 0.5 %).
  struct Measure {
    double volume_m3, min_skin_distance_m, min_chest_distance_m;
  };
  [[nodiscard]] Measure measure() const;
  [[nodiscard]] double exact_volume() const { return measure().volume_m3; }  ///< [m3]

 private:
  /// Which of the two caps can matter within some reach of a point; the other needs no search.
  struct Caps {
    bool skin, chest;
  };
  [[nodiscard]] Caps caps_near(const Vec3& p, double reach) const;
  [[nodiscard]] double lateral(const Vec3& p) const;
  [[nodiscard]] double shape(const Vec3& p, Caps caps) const;
  [[nodiscard]] double value(const Vec3& p, Caps caps) const;
  [[nodiscard]] double cut_share(const std::array<Vec3, 4>& t, int n, Caps caps) const;
  void place_axis(const Plan& plan);
  void place_outline(const Plan& plan);
  [[nodiscard]] std::vector<std::array<double, 2>> sector(const Segment& segment) const;
  void fill_piece();
  void measure_cell(const std::array<int, 3>& low, Measure& sum) const;

  /// Samples of the piece around the tumour on a grid along the axis.
  struct Sample {
    float depth = 0.0F;               ///< below the surface [m]; negative or 0: not in the piece
    float skin = 0.0F, chest = 0.0F;  ///< lower bounds of the distances to both [m]
  };
  struct Grid {
    Vec3 e1{}, e2{};
    double step = 0.0;
    int half_width = 0, half_length = 0;
    std::vector<Sample> samples;
    [[nodiscard]] bool holds(const std::array<int, 3>& at) const;
    [[nodiscard]] std::size_t index(const std::array<int, 3>& at) const;
  };
  [[nodiscard]] std::array<double, 3> grid_position(const Vec3& p) const;
  [[nodiscard]] Sample sample(const std::array<int, 3>& at, const Sample& neighbour);
  [[nodiscard]] Vec3 sample_point(double i, double j, double k) const;
  [[nodiscard]] bool in_piece(const Vec3& p) const;

  /// Distance to a surface; remembers the last closest triangle, since queries come in rows. With a
  /// field it is interpolated.
  struct Neighbour {
    const SurfaceTree* tree;
    const DistanceField* field = nullptr;
    mutable int last = -1;
    [[nodiscard]] double distance(const Vec3& p, double reach) const {
      return field != nullptr ? std::min((*field)(p), reach) : tree->distance(p, reach, last);
    }
  };
  static constexpr double any_reach = std::numeric_limits<double>::infinity();

  std::shared_ptr<const Anatomy> anatomy_;
  Neighbour skin_tree_, chest_tree_;
  Vec3 axis_{}, chest_{}, skin_{}, centre_{};
  double radius_ = 0.0, clearance_ = 0.0, blend_ = 0.0;
  std::vector<std::array<double, 2>> outline_;  // across the axis, empty for cylinders
  Detail detail_;
  Grid grid_;
  bool meets_clip_planes_ = false;
};

struct Wound {
  std::vector<double> fraction;  ///< per cell, 0..1: share of the cell's volume that is removed
  double excised_m3 = 0.0;       ///< sum of fraction x cell volume in the pose of the plan
  double exact_m3 = 0.0;         ///< volume of the exact shape
  double min_skin_distance_m = 0.0, min_chest_distance_m = 0.0;
  std::vector<std::vector<int>> incision_vertices;  ///< skin vertices along each incision line
  std::vector<std::string> warnings;
};
Wound resect(const Plan& plan, std::shared_ptr<const Anatomy> anatomy, const Context& ctx,
             Detail detail = Detail::Full);
Wound resect(const Plan& plan, const TetMesh& mesh, std::span<const Vec3> points,
             double midline_x_m, const Context& ctx, Detail detail = Detail::Full);

}  // namespace sanatrix::surgery

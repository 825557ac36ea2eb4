#include "standing/marks.hpp"

#include "core/error.hpp"
#include "geometry/distance.hpp"

namespace sanatrix::standing {
namespace {

constexpr double most_off_skin_m = 0.03;
constexpr std::array nipple_name{"nipple_R", "nipple_L"};
constexpr auto swapped_hint =
    "swap nipple_R and nipple_L (the patient's own right and left) if they are mixed up; if they "
    "are right, the scan is mirrored: export it again without a mirror or a negative scale";

void check_on_skin(const SurfaceTree& skin, const std::optional<Vec3>& mark, const char* name) {
  const double off = mark ? skin.closest(*mark).distance : 0.0;
  if (off > most_off_skin_m) {
    throw Error(Fault::Input,
                fmt::format("the landmark {} lies {:.0f} mm off the scanned skin", name, 1e3 * off),
                "mark it in this scan's own frame, in millimetres");
  }
}

/// Mean of area times normal around a place.
Vec3 facing(const TriMesh& scan, const Vec3& place) {
  constexpr double around_m = 0.03;
  Vec3 sum{};
  for (const auto& [a, b, c] : scan.triangles) {
    const Vec3& p = scan.points[static_cast<std::size_t>(a)];
    if (norm(p - place) < around_m) {
      sum += cross(scan.points[static_cast<std::size_t>(b)] - p,
                   scan.points[static_cast<std::size_t>(c)] - p);
    }
  }
  return sum;
}

}  // namespace

void check_marks(const TriMesh& scan, const ScanLandmarks& marks) {
  const SurfaceTree skin(scan);
  for (const std::size_t side : {0U, 1U}) {
    check_on_skin(skin, marks.nipple[side], nipple_name[side]);
  }
  check_on_skin(skin, marks.sternal_notch, "sternal_notch");
  if (marks.nipple[0] && marks.nipple[1] && marks.sternal_notch) {
    const Vec3 left = *marks.nipple[1] - *marks.nipple[0];
    const Vec3 up = *marks.sternal_notch - 0.5 * (*marks.nipple[0] + *marks.nipple[1]);
    const Vec3 looks = facing(scan, *marks.nipple[0]) + facing(scan, *marks.nipple[1]);
    if (dot(looks, cross(up, left)) > 0) {  // up x left points to her back
      throw Error(Fault::Input,
                  "the landmarks contradict the scan: as marked, her breasts would look backwards",
                  swapped_hint);
    }
  }
}

void check_marks(const ScanFrame& frame, const ScanLandmarks& marks) {
  constexpr double least_apart_m = 0.05;  // else a mark lies on the breast of the other
  const bool any = marks.nipple[0] || marks.nipple[1];
  if (any && frame.nipple[1][0] - frame.nipple[0][0] < least_apart_m) {
    const std::size_t side = marks.nipple[1] ? 1 : 0;
    throw Error(Fault::Input,
                fmt::format("the landmark {} lies on the patient's {} as she stands in the scan",
                            nipple_name[side], side == 1 ? "right" : "left"),
                swapped_hint);
  }
  if (marks.sternal_notch && frame.sternal_notch &&
      (*frame.sternal_notch)[2] < std::max(frame.nipple[0][2], frame.nipple[1][2])) {
    throw Error(Fault::Input, "the landmark sternal_notch lies below the nipples",
                "mark the hollow between the collar bones, or say which way is up (up_scan)");
  }
}

}  // namespace sanatrix::standing

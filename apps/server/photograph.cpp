// The patient's own skin: her photographed scan, and where the prediction moves it.
#include "bundle.hpp"
#include "core/error.hpp"
#include "io/scan_file.hpp"
#include "pipeline/result.hpp"
#include "pipeline/scans.hpp"
#include "view_api.hpp"

namespace sanatrix::server {

std::string photograph_bundle(const pipeline::Case& patient, const std::filesystem::path& scratch) {
  Silent silent;
  const Context ctx("photograph", silent);
  const pipeline::CaseResult result = pipeline::load_result(patient);
  const pipeline::Skin skin = pipeline::skin_of(result);
  const pipeline::Scans scans = pipeline::load_scans(
      patient, result, skin, patient.stage_folder(pipeline::Stage::Outcome) / "scan_poses.bin",
      scratch, ctx);
  std::error_code none;
  std::filesystem::remove(scratch, none);
  require(scans.preop && scans.preop->placed.surface.has_photograph(),
          "this case has no scan with a photograph");
  const SeamlessSurface surface = split_at_seams(scans.preop->placed.surface);
  std::vector<Vec3> after;
  after.reserve(surface.mesh.points.size());
  std::vector<float> corners;
  for (std::size_t v = 0; v < surface.mesh.points.size(); ++v) {
    const auto origin = static_cast<std::size_t>(surface.origin[v]);
    after.push_back(surface.mesh.points[v] + scans.preop->displacement[origin]);
    corners.insert(corners.end(), surface.corner[v].begin(), surface.corner[v].end());
  }
  std::vector<std::uint32_t> triangles;
  for (const auto& t : surface.mesh.triangles) {
    for (const int v : t) {
      triangles.push_back(static_cast<std::uint32_t>(v));
    }
  }
  const std::string jpeg = io::jpeg_bytes(scans.preop->placed.surface.photograph);
  Bundle bundle;
  bundle.add("triangles", triangles);
  bundle.add("corners", corners);
  bundle.add_mm("points.before", surface.mesh.points);
  bundle.add_mm("points.after", after);
  bundle.add("jpeg", std::span(reinterpret_cast<const std::uint8_t*>(jpeg.data()), jpeg.size()));
  return bundle.bytes();
}

}  // namespace sanatrix::server

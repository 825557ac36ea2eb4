// Pictures by VTK on a display of our own making (Xvfb). Every picture has orientation letters, a
// colour bar with name, unit and range, and the patient's side in words.
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/textured_surface.hpp"

namespace sanatrix::render {

/// Software rendering of a report takes seconds; what takes longer than this hangs.
inline constexpr std::chrono::seconds draw_limit{300};
/// Runs `work` in a child process that owns an off-screen display, so that a failure of the
/// graphics stack never ends the caller. Returns the reason when no picture could be made, else
/// nothing. Stop of `ctx` ends the child within a moment and throws Cancelled; pictures are whole
/// or absent.
std::optional<std::string> with_display(const std::function<void()>& work, const Context& ctx,
                                        std::chrono::seconds limit = draw_limit);
/// The same with several child processes at once, each with a share of the work, on one display.
std::optional<std::string> with_display(const std::vector<std::function<void()>>& shares,
                                        const Context& ctx,
                                        std::chrono::seconds limit = draw_limit);

/// From where one looks at the patient, superior up; Below is a radiologist's axial view: from the
/// feet, anterior up. In Front the patient's left is on the right hand of the picture.
enum class View { Front, LeftOblique, RightOblique, Left, Right, Below };

/// A surface with optional colours, and where it comes from.
struct Actor {
  TriMesh surface;
  std::vector<double> scalar;  ///< per point, empty: plain colour
  std::array<double, 3> colour{0.83, 0.66, 0.56};
  double opacity = 1.0;
  bool wireframe = false;
  /// Per point [m], empty: none. Outside the surface: outward ones begin on it, inward ones end on
  /// it. Of crowded arrows the longest, none below a tenth of the longest of all.
  std::vector<Vec3> arrows;
  double arrow_scale = 1.0;           ///< drawn this many times as long; say it in the title
  std::vector<Vec3> normals;          ///< per point, empty: of the surface
  std::vector<TextureCorner> corner;  ///< per point, with a photograph
  std::shared_ptr<const Photograph> photograph;
};
/// A surface with its photograph; faces without one are plain.
std::vector<Actor> textured(const TexturedSurface& surface);
/// The end of a colour bar from 0 that holds `high` and whose quarters are short numbers.
double nice_top(double high);
struct Panel {
  std::vector<Actor> actors;
  View view = View::Front;
  std::string title;
  std::string bar_title;  ///< "displacement [mm]"; empty: no colour bar
  double bar_min = 0.0, bar_max = 1.0;
  bool diverging = false;  ///< else viridis
};
/// Panels side by side, `columns` per row. All panels show the same region of space at the same
/// scale, so that they can be compared. Written aside and renamed. Needs a display.
void write_picture(const std::vector<Panel>& panels, int columns, const std::filesystem::path& file,
                   int panel_width = 640, int panel_height = 560);

/// A mesh cut open by a plane: the cut face coloured by a point field, the half behind it
/// translucent. Seen square to the plane from the usual side: axial from the feet, coronal from the
/// front, sagittal from the patient's left.
struct CutPanel {
  const TetMesh* mesh;
  std::vector<Vec3> points;
  std::vector<double> scalar;  ///< per vertex
  Vec3 plane_point, plane_normal;
  std::string title, bar_title;
  double bar_min = 0.0, bar_max = 1.0;
  /// Half edge of the cube around plane_point outside which nothing is drawn [m]; 0: no limit.
  double window_m = 0.0;
};
void write_cuts(const std::vector<CutPanel>& panels, int columns, const std::filesystem::path& file,
                int panel_width = 480, int panel_height = 420);

struct Curve {
  std::string name;
  std::vector<double> x, y;
};
void write_plot(const std::vector<Curve>& curves, const std::string& title,
                const std::string& x_label, const std::string& y_label,
                const std::filesystem::path& file);

}  // namespace sanatrix::render

// The paper's Figs 4-7 of this case, and its four poses, as PNG.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/wound_view.hpp"
#include "render/render.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
constexpr std::array<double, 3> wound_red{0.75, 0.15, 0.15}, tumour_violet{0.35, 0.05, 0.45},
    line_blue{0.0, 0.3, 0.65};

TriMesh skin_of(const CaseResult& r, const SolvedShape& pose) {
  return extract_surface(r.model.mesh, r.points(pose), {"skin"}).mesh;
}

render::Actor actor(TriMesh surface) {
  render::Actor a;
  a.surface = std::move(surface);
  return a;
}

std::string side_words(const CaseResult& r) {
  return r.side() > 0 ? "patient's LEFT breast operated" : "patient's RIGHT breast operated";
}
render::View operated_view(const CaseResult& r) {
  return r.side() > 0 ? render::View::LeftOblique : render::View::RightOblique;
}
render::View operated_profile(const CaseResult& r) {
  return r.side() > 0 ? render::View::Left : render::View::Right;
}

render::Panel panel(std::vector<render::Actor> actors, render::View view, std::string title) {
  render::Panel p;
  p.actors = std::move(actors);
  p.view = view;
  p.title = std::move(title);
  return p;
}

void write_poses(const CaseResult& r, const fs::path& file) {
  const TriMesh prone = extract_surface(r.model.mesh, r.model.mesh.points, {"skin"}).mesh;
  const std::vector<std::pair<std::string, TriMesh>> poses{
      {r.standing ? "standing (scanned)" : "prone (given)", prone},
      {"unloaded", skin_of(r, r.unloaded)},
      {"supine", skin_of(r, r.supine)},
      {"upright before surgery", skin_of(r, r.before)}};
  std::vector<render::Panel> panels;
  for (const render::View view : {render::View::Front, operated_profile(r)}) {
    for (const auto& [title, skin] : poses) {
      panels.push_back(panel({actor(skin)}, view, title));
    }
  }
  render::write_picture(panels, 4, file, 420, 380);
}

/// Fig 4: tumour, planned cylinder and the elements that are removed.
void write_plan(const CaseResult& r, const fs::path& file) {
  const PlanShapes shapes = plan_shapes(r);
  render::Actor skin = actor(skin_of(r, r.supine));
  skin.opacity = 0.3;
  render::Actor tumour = actor(shapes.tumour);
  tumour.colour = tumour_violet;
  render::Actor planned = actor(shapes.planned);
  planned.colour = line_blue;
  planned.wireframe = true;
  render::Actor resected = actor(shapes.resected);
  resected.colour = wound_red;
  resected.opacity = 0.35;
  render::Actor edges = resected;
  edges.opacity = 0.25;
  edges.colour = {0.45, 0.08, 0.08};
  edges.wireframe = true;
  const std::vector<render::Actor> actors{tumour, planned, edges, resected, skin};
  render::write_picture({panel(actors, render::View::Front, "plan (supine): " + side_words(r)),
                         panel(actors, operated_view(r), "violet: tumour, blue: planned cylinder"),
                         panel(actors, operated_profile(r), "red: resected elements")},
                        3, file);
}

/// Colour range in which one species moves, over all frames.
std::pair<double, double> range_of(const CaseResult& r, std::size_t species) {
  double high = 0.0;
  for (const Frame& frame : r.frames) {
    for (std::size_t i = species; i < frame.species.size(); i += r.species.size()) {
      high = std::max(high, frame.species[i]);
    }
  }
  return {0.0, render::nice_top(high)};
}

std::vector<const Frame*> snapshots(const CaseResult& r) {
  std::vector<const Frame*> chosen;
  for (const double share : {0.0, 1.0 / 15, 2.0 / 15, 4.0 / 15, 1.0}) {
    const double day = share * r.frames.back().t_day;
    const auto nearest = std::ranges::min_element(
        r.frames, {}, [&](const Frame& frame) { return std::abs(frame.t_day - day); });
    if (chosen.empty() || chosen.back() != &*nearest) {
      chosen.push_back(&*nearest);
    }
  }
  return chosen;
}

void write_species(const CaseResult& r, const fs::path& file) {
  constexpr double window_m = 0.055;
  const TetMesh part = cells_near_wound(r, window_m);
  const std::vector<const Frame*> frames = snapshots(r);
  std::vector<render::CutPanel> panels;
  for (std::size_t s = 0; s < r.species.size(); ++s) {
    const auto [low, high] = range_of(r, s);
    for (const Frame* frame : frames) {
      std::vector<double> values;
      for (std::size_t i = s; i < frame->species.size(); i += r.species.size()) {
        values.push_back(frame->species[i]);
      }
      panels.push_back({.mesh = &part,
                        .points = frame->points,
                        .scalar = std::move(values),
                        .plane_point = wound_centre(r, frame->points),
                        .plane_normal = {0, 0, 1},
                        .title = fmt::format("day {:g}", frame->t_day),
                        .bar_title = r.species[s].label + " [-]",
                        .bar_min = low,
                        .bar_max = high,
                        .window_m = window_m});
    }
  }
  render::write_cuts(panels, static_cast<int>(frames.size()), file, 320, 280);
}

void write_histories(const CaseResult& r, const fs::path& folder) {
  render::Curve volume{"wound", {}, {}};
  std::vector<render::Curve> means;
  for (const healing::Species& species : r.species) {
    means.push_back({species.label, {}, {}});
  }
  for (const recovery::HistoryRow& row : r.history) {
    volume.x.push_back(row.species.t_day);
    volume.y.push_back(row.volume_ratio);
    for (std::size_t s = 0; s < means.size(); ++s) {
      means[s].x.push_back(row.species.t_day);
      means[s].y.push_back(row.species.mean[s]);
    }
  }
  render::write_plot({volume}, "Volume of the operated region", "days after surgery", "V / V0",
                     folder / "fig6_volume.png");
  render::write_plot(means, "Means over the operated region", "days after surgery",
                     "relative to healthy tissue", folder / "species_means.png");
}

void write_displacement(const CaseResult& r, const fs::path& file) {
  const Surface skin = extract_surface(r.model.mesh, r.points(r.after), {"skin"});
  render::Actor after = actor(skin.mesh);
  double high = 0.0;
  for (const int vertex : skin.vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    after.arrows.push_back(r.points(r.after)[v] - r.points(r.before)[v]);
    after.scalar.push_back(1e3 * norm(after.arrows.back()));
    high = std::max(high, after.scalar.back());
  }
  // The longest arrow is to be about as long as an areola is wide.
  constexpr double wanted_mm = 25.0;
  for (const double scale : {2.0, 5.0, 10.0, 20.0, 50.0}) {
    after.arrow_scale = high * scale <= wanted_mm ? scale : after.arrow_scale;
  }
  std::vector<render::Panel> panels;
  for (const render::View view : {render::View::Front, operated_view(r)}) {
    panels.push_back(panel({actor(skin_of(r, r.before))}, view, "upright before surgery"));
    panels.push_back(panel({after}, view,
                           view == render::View::Front
                               ? "after healing: " + side_words(r)
                               : fmt::format("arrows {:g} times as long", after.arrow_scale)));
    panels.back().bar_title = "displacement [mm]";
    panels.back().bar_max = render::nice_top(high);
  }
  render::write_picture(panels, 2, file);
}

}  // namespace

std::optional<std::string> write_pictures(const CaseResult& result, const fs::path& folder,
                                          const Context& ctx) {
  // Two shares of about equal time: most machines have two cores to spare.
  const std::vector<std::function<void()>> shares{
      [&] {
        write_poses(result, folder / "poses.png");
        write_plan(result, folder / "fig4_plan.png");
      },
      [&] {
        write_species(result, folder / "fig5_species.png");
        write_histories(result, folder);
        write_displacement(result, folder / "fig7_displacement.png");
      }};
  return render::with_display(shares, ctx);
}

}  // namespace sanatrix::pipeline

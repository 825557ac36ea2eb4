#include "report/views.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include "render/render.hpp"

namespace sanatrix::report {
namespace {

namespace fs = std::filesystem;
using render::View;

constexpr std::array five_views{View::Front, View::RightOblique, View::LeftOblique, View::Right,
                                View::Left};
constexpr std::array view_names{"frontal", "right oblique", "left oblique", "right lateral",
                                "left lateral"};

render::Panel panel(std::vector<render::Actor> actors, View view, std::string title) {
  render::Panel p;
  p.actors = std::move(actors);
  p.view = view;
  p.title = std::move(title);
  return p;
}

void draw_five(const ClaySkin& skin, const fs::path& file) {
  std::vector<render::Panel> panels;
  for (const auto& [surface, when] : {std::pair{&skin.before, "before"}, {&skin.after, "after"}}) {
    const std::vector<render::Actor> actors = render::textured(*surface);
    for (std::size_t i = 0; i < five_views.size(); ++i) {
      panels.push_back(panel(actors, five_views[i], fmt::format("{}, {}", when, view_names[i])));
    }
  }
  render::write_picture(panels, 5, file, 400, 420);
}

/// NaN (no counterpart) is drawn grey by the colour table.
render::Actor coloured(const TriMesh& surface, std::vector<double> values) {
  render::Actor actor;
  actor.surface = surface;
  actor.scalar = std::move(values);
  return actor;
}

std::vector<double> millimetres(std::span<const double> metres, bool absolute) {
  std::vector<double> mm;
  for (const double d : metres) {
    mm.push_back(1e3 * (absolute ? std::abs(d) : d));
  }
  return mm;
}

void draw_distances(const Findings& f, const fs::path& file) {
  const View oblique = f.result.side() > 0 ? View::LeftOblique : View::RightOblique;
  const pipeline::FollowupScan& followup = *f.scans.followup;
  std::vector<render::Panel> panels;
  for (const View view : {View::Front, oblique}) {
    render::Actor scan;
    scan.surface = moved(followup.placed.surface.mesh, followup.best_fit);
    panels.push_back(panel({scan}, view, "follow-up scan"));
    panels.push_back(
        panel({coloured(f.skin.after, millimetres(followup.distance, true))}, view, "prediction"));
    panels.back().bar_title = "distance from the follow-up scan [mm]";
    panels.back().bar_max = 10;
    if (f.scans.observed) {
      std::vector<double> outward = millimetres(f.scans.observed->inward, false);
      for (double& d : outward) {
        d = -d;
      }
      panels.push_back(panel({coloured(f.scans.preop->placed.surface.mesh, std::move(outward))},
                             view, "what really changed"));
      panels.back().bar_title = "outward (+), inward (-) since before surgery [mm]";
      panels.back().bar_min = -10;
      panels.back().bar_max = 10;
      panels.back().diverging = true;
    }
  }
  render::write_picture(panels, f.scans.observed ? 3 : 2, file, 560, 480);
}

std::vector<double> displacement_mm(const Findings& f) {
  std::vector<double> mm;
  for (const Vec3& u : f.skin.displacement()) {
    mm.push_back(1e3 * norm(u));
  }
  return mm;
}

}  // namespace

ClaySkin clay_skin(const Findings& f) {
  const auto nipple = [&](std::size_t side) {
    return f.result.points(
        f.result.before)[static_cast<std::size_t>(f.result.model.nipple_vertex[side])];
  };
  ClaySkin skin{outcome::clay(f.skin.before.mesh, {nipple(0), nipple(1)}), {}};
  skin.after = skin.before;
  skin.after.mesh = f.skin.after;
  return skin;
}

std::optional<ClaySkin> photographed_skin(const Findings& f) {
  if (!f.scans.preop || !f.scans.preop->placed.surface.has_photograph()) {
    return std::nullopt;
  }
  ClaySkin skin{f.scans.preop->placed.surface, f.scans.preop->placed.surface};
  for (std::size_t v = 0; v < skin.after.mesh.points.size(); ++v) {
    skin.after.mesh.points[v] += f.scans.preop->displacement[v];
  }
  return skin;
}

std::optional<std::string> draw_views(const Findings& f, const fs::path& folder,
                                      const Context& ctx) {
  std::vector<std::function<void()>> shares{[&] { draw_five(clay_skin(f), folder / "views.png"); },
                                            [&] {
                                              if (const auto photographed = photographed_skin(f)) {
                                                draw_five(*photographed,
                                                          folder / "views_photo.png");
                                              }
                                              if (f.scans.followup) {
                                                draw_distances(f, folder / "distance.png");
                                              }
                                            }};
  return render::with_display(shares, ctx);
}

std::optional<std::string> draw_comparison(const std::vector<Findings>& cases, const fs::path& file,
                                           const Context& ctx) {
  double highest = 0.1;
  for (const Findings& f : cases) {
    highest = std::max(highest, std::ranges::max(displacement_mm(f)));
  }
  const auto draw = [&] {
    std::vector<render::Panel> panels;
    for (const Findings& f : cases) {
      const ClaySkin skin = clay_skin(f);
      const View oblique = f.result.side() > 0 ? View::LeftOblique : View::RightOblique;
      panels.push_back(panel(render::textured(skin.before), View::Front, f.folder + ", before"));
      panels.push_back(panel(render::textured(skin.after), View::Front, f.folder + ", after"));
      panels.push_back(panel(render::textured(skin.after), oblique, f.folder + ", after"));
      panels.push_back(
          panel({coloured(f.skin.after, displacement_mm(f))}, oblique, f.folder + ", change"));
      panels.back().bar_title = "displacement [mm]";
      panels.back().bar_max = render::nice_top(highest);
    }
    render::write_picture(panels, 4, file, 460, 440);
  };
  return render::with_display(draw, ctx);
}

}  // namespace sanatrix::report

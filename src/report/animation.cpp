// The paper's S1-S3 Videos: healing in the operating pose, cut open, with the curve below.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"
#include "render/render.hpp"
#include "report/external.hpp"
#include "report/views.hpp"

namespace sanatrix::report {
namespace {

namespace fs = std::filesystem;

constexpr int frames_in_all = 46, frames_per_second = 12;

pipeline::Frame between(const pipeline::Frame& a, const pipeline::Frame& b, double share) {
  pipeline::Frame mixed = a;
  mixed.t_day = (1 - share) * a.t_day + share * b.t_day;
  for (std::size_t i = 0; i < a.species.size(); ++i) {
    mixed.species[i] = (1 - share) * a.species[i] + share * b.species[i];
  }
  for (std::size_t v = 0; v < a.points.size(); ++v) {
    mixed.points[v] = (1 - share) * a.points[v] + share * b.points[v];
  }
  return mixed;
}

pipeline::Frame at_day(const std::vector<pipeline::Frame>& frames, double day) {
  const auto next = std::ranges::find_if(
      frames, [&](const pipeline::Frame& frame) { return frame.t_day >= day; });
  if (next == frames.begin() || next == frames.end()) {
    return next == frames.end() ? frames.back() : frames.front();
  }
  const pipeline::Frame& before = *(next - 1);
  return between(before, *next, (day - before.t_day) / (next->t_day - before.t_day));
}

Vec3 wound_centre(const pipeline::CaseResult& r, std::span<const Vec3> pose) {
  const std::vector<double> volume = cell_volumes(r.model.mesh, pose);
  Vec3 centre{};
  double total = 0;
  for (std::size_t c = 0; c < volume.size(); ++c) {
    const double weight = 0.25 * volume[c] * r.wound.fraction[c];
    for (const int vertex : r.model.mesh.cells[c]) {
      centre += weight * pose[static_cast<std::size_t>(vertex)];
    }
    total += 4 * weight;
  }
  return (1 / total) * centre;
}

/// What one video shows: a colour per vertex and a curve.
struct Subject {
  std::string file, title, bar, curve_label;
  std::function<std::vector<double>(const pipeline::Frame&)> colour;
  double high;
  render::Curve curve;
};

render::Curve until(const render::Curve& whole, double day) {
  render::Curve part{"so far", {}, {}};
  for (std::size_t i = 0; i < whole.x.size(); ++i) {
    if (whole.x[i] <= day || part.x.empty()) {
      part.x.push_back(whole.x[i]);
      part.y.push_back(whole.y[i]);
    }
  }
  return part;
}

void draw_frames(const Findings& f, const Subject& subject, const fs::path& folder) {
  const pipeline::CaseResult& r = f.result;
  const Vec3 centre = wound_centre(r, r.frames.front().points);
  for (int i = 0; i < frames_in_all; ++i) {
    const double day = r.frames.back().t_day * i / (frames_in_all - 1);
    const pipeline::Frame frame = at_day(r.frames, day);
    render::CutPanel cut{.mesh = &r.model.mesh,
                         .points = frame.points,
                         .scalar = subject.colour(frame),
                         .plane_point = centre,
                         .plane_normal = {0, 0, 1},
                         .title = fmt::format("{}, day {:.0f}", subject.title, day),
                         .bar_title = subject.bar,
                         .bar_min = 0.0,
                         .bar_max = subject.high};
    render::write_cuts({cut}, 1, folder / fmt::format("cut_{:03d}.png", i), 900, 620);
    render::write_plot({subject.curve, until(subject.curve, day)}, "", "days after surgery",
                       subject.curve_label, folder / fmt::format("curve_{:03d}.png", i));
  }
}

std::vector<Subject> subjects(const Findings& f) {
  const pipeline::CaseResult& r = f.result;
  std::vector<Subject> all;
  const std::vector<Vec3>& start = r.frames.front().points;
  Subject moved{"displacement.mp4",
                "displacement (supine)",
                "displacement since surgery [mm]",
                "largest of the skin, against before surgery [mm]",
                {},
                0.1,
                {"all days", {}, {}}};
  moved.colour = [&start](const pipeline::Frame& frame) {
    std::vector<double> mm;
    for (std::size_t v = 0; v < start.size(); ++v) {
      mm.push_back(1e3 * norm(frame.points[v] - start[v]));
    }
    return mm;
  };
  for (const pipeline::Frame& frame : r.frames) {
    moved.high = std::max(moved.high, std::ranges::max(moved.colour(frame)));
  }
  for (const auto& row : r.history) {
    moved.curve.x.push_back(row.species.t_day);
    moved.curve.y.push_back(row.max_displacement_mm);
  }
  all.push_back(std::move(moved));
  for (const auto& [key, file] : {std::pair{"nu", "capillaries.mp4"}, {"eta", "cells.mp4"}}) {
    const auto species = std::ranges::find_if(
        r.species, [key = key](const healing::Species& s) { return s.key == key; });
    if (species == r.species.end()) {
      continue;
    }
    const auto number = static_cast<std::size_t>(species - r.species.begin());
    Subject subject{
        file, species->label,      species->label + " [-]", "mean in the operated region [-]", {},
        0.1,  {"all days", {}, {}}};
    subject.colour = [number, count = r.species.size()](const pipeline::Frame& frame) {
      std::vector<double> values;
      for (std::size_t i = number; i < frame.species.size(); i += count) {
        values.push_back(frame.species[i]);
      }
      return values;
    };
    for (const pipeline::Frame& frame : r.frames) {
      subject.high = std::max(subject.high, std::ranges::max(subject.colour(frame)));
    }
    for (const auto& row : r.history) {
      subject.curve.x.push_back(row.species.t_day);
      subject.curve.y.push_back(row.species.mean[number]);
    }
    all.push_back(std::move(subject));
  }
  return all;
}

}  // namespace

std::optional<std::string> draw_animations(const Findings& f, const fs::path& folder) {
  for (const Subject& subject : subjects(f)) {
    const fs::path aside = folder / ("frames-" + fs::path(subject.file).stem().string());
    fs::create_directories(aside);
    auto reason = render::with_display([&] { draw_frames(f, subject, aside); });
    if (!reason) {
      reason = run_external(
          "ffmpeg",
          {"-y", "-loglevel", "error", "-framerate", std::to_string(frames_per_second), "-i",
           (aside / "cut_%03d.png"), "-framerate", std::to_string(frames_per_second), "-i",
           (aside / "curve_%03d.png"), "-filter_complex", "[1]scale=900:380[c];[0][c]vstack",
           "-c:v", "libx264", "-pix_fmt", "yuv420p", (folder / subject.file)},
          120);
    }
    fs::remove_all(aside);
    if (reason) {
      return reason;
    }
  }
  return std::nullopt;
}

}  // namespace sanatrix::report

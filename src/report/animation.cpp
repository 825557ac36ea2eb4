// The paper's S1-S3 Videos: healing in the operating pose, cut open, with the curve below.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"
#include "pipeline/wound_view.hpp"
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

/// What one video shows: a colour per vertex.
struct Subject {
  std::string file, title, bar;
  std::function<std::vector<double>(const pipeline::Frame&)> colour;
  double high;
};

/// The wound's volume over all days, and what of it has passed.
std::pair<render::Curve, render::Curve> volume_curves(const pipeline::CaseResult& r, double day) {
  render::Curve whole{"all days", {}, {}}, gone{"so far", {}, {}};
  for (const auto& row : r.history) {
    whole.x.push_back(row.species.t_day);
    whole.y.push_back(100 * row.volume_ratio);
    if (row.species.t_day <= day || gone.x.empty()) {
      gone.x.push_back(whole.x.back());
      gone.y.push_back(whole.y.back());
    }
  }
  return {std::move(whole), std::move(gone)};
}

/// Every second frame from `first` on: two processes share the work.
void draw_frames(const Findings& f, const Subject& subject, const fs::path& folder, int first) {
  constexpr double window_m = 0.09;
  const pipeline::CaseResult& r = f.result;
  const TetMesh part = pipeline::cells_near_wound(r, window_m);
  const Vec3 centre = pipeline::wound_centre(r, r.frames.front().points);
  for (int i = first; i < frames_in_all; i += 2) {
    const double day = r.frames.back().t_day * i / (frames_in_all - 1);
    const pipeline::Frame frame = at_day(r.frames, day);
    render::CutPanel cut{.mesh = &part,
                         .points = frame.points,
                         .scalar = subject.colour(frame),
                         .plane_point = centre,
                         .plane_normal = {0, 0, 1},
                         .title = fmt::format("{}, day {:.0f}", subject.title, day),
                         .bar_title = subject.bar,
                         .bar_min = 0.0,
                         .bar_max = render::nice_top(subject.high),
                         .window_m = window_m};
    render::write_cuts({cut}, 1, folder / fmt::format("cut_{:03d}.png", i), 900, 620);
    const auto [whole, gone] = volume_curves(r, day);
    render::write_plot({whole, gone}, "", "days after surgery", "volume of the operated region [%]",
                       folder / fmt::format("curve_{:03d}.png", i));
  }
}

std::vector<Subject> subjects(const Findings& f) {
  const pipeline::CaseResult& r = f.result;
  std::vector<Subject> all;
  const std::vector<Vec3>& start = r.frames.front().points;
  Subject moved{
      "displacement.mp4", "displacement (supine)", "displacement since surgery [mm]", {}, 0.1};
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
  all.push_back(std::move(moved));
  for (const auto& [key, file] : {std::pair{"nu", "capillaries.mp4"}, {"eta", "cells.mp4"}}) {
    const auto species = std::ranges::find_if(
        r.species, [key = key](const healing::Species& s) { return s.key == key; });
    if (species == r.species.end()) {
      continue;
    }
    const auto number = static_cast<std::size_t>(species - r.species.begin());
    Subject subject{file, species->label, species->label + " [healthy = 1]", {}, 0.1};
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
    all.push_back(std::move(subject));
  }
  return all;
}

}  // namespace

std::optional<std::string> draw_animations(const Findings& f, const fs::path& folder,
                                           const Context& ctx) {
  // Software rendering of one video takes half a minute on a quiet machine.
  constexpr std::chrono::seconds limit{1800};
  const std::vector<Subject> all = subjects(f);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Subject& subject = all[i];
    ctx.at(static_cast<double>(i) / static_cast<double>(all.size()), subject.file);
    const fs::path aside = folder / ("frames-" + fs::path(subject.file).stem().string());
    fs::create_directories(aside);
    auto reason = render::with_display({[&] { draw_frames(f, subject, aside, 0); },
                                        [&] {
                                          draw_frames(f, subject, aside, 1);
                                        }},
                                       ctx, limit);
    if (!reason) {
      const std::string rate = std::to_string(frames_per_second);
      reason = run_external(
          "ffmpeg",
          {"-y", "-loglevel", "error", "-framerate", rate, "-i", (aside / "cut_%03d.png"),
           "-framerate", rate, "-i", (aside / "curve_%03d.png"), "-filter_complex",
           "[1]scale=900:380[c];[0][c]vstack", "-c:v", "libx264", "-pix_fmt", "yuv420p",
           (folder / subject.file)},
          120, ctx);
    }
    fs::remove_all(aside);
    if (reason) {
      return reason;
    }
  }
  return std::nullopt;
}

}  // namespace sanatrix::report

// Pictures are made in a child process and show something; failures come back as a reason.
#include "render/render.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "own_folder.hpp"
#include "simple_meshes.hpp"

namespace sanatrix::render {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

Context quiet(std::stop_token stop = {}) {
  static Silent silent;
  return Context("pictures", silent, std::move(stop));
}

class Pictures : public ::testing::Test {
 protected:
  ~Pictures() override {
    if (std::getenv("SANATRIX_KEEP_PICTURES") == nullptr) {
      fs::remove_all(folder_);
    }
  }
  fs::path folder_ = testing::own_folder();
};

/// Skips where there is no Xvfb; any other reason is a failure.
#define SANATRIX_DRAW(...)                                      \
  if (const auto reason = with_display(__VA_ARGS__, quiet())) { \
    if (reason->find("install Xvfb") != std::string::npos) {    \
      GTEST_SKIP() << *reason;                                  \
    }                                                           \
    FAIL() << *reason;                                          \
  }

/// Two half balls, domes forward; the patient's left one is drawn down, the right one forward.
Actor breasts() {
  Actor actor;
  for (const double x : {-0.075, 0.075}) {
    const TriMesh ball = testing::sphere(40, 0.065, {x, 0, 0});
    const int offset = static_cast<int>(actor.surface.points.size());
    for (const Vec3& p : ball.points) {
      const double height = std::max(-p[1], 0.0);
      actor.surface.points.push_back({p[0], -height, p[2]});
      actor.arrows.push_back(x > 0 ? Vec3{0, 0, -0.25 * height} : Vec3{0, -0.1 * height, 0});
      actor.scalar.push_back(1e3 * norm(actor.arrows.back()));
    }
    for (const auto& [a, b, c] : ball.triangles) {
      actor.surface.triangles.push_back({a + offset, b + offset, c + offset});
    }
  }
  return actor;
}

/// The same frame and words with a surface too thin to be seen.
Actor nothing_in_the_same_place() {
  Actor actor = breasts();
  actor.surface.triangles.resize(1);
  actor.arrows.clear();
  actor.scalar.clear();
  return actor;
}

Panel panel_of(Actor actor, View view) {
  return {.actors = {std::move(actor)},
          .view = view,
          .title = "Upright, 30 days after surgery",
          .bar_title = "displacement [mm]",
          .bar_min = 0,
          .bar_max = 16};
}

bool is_png(const fs::path& file) {
  return read_text(file).starts_with("\x89PNG\r\n\x1a\n");
}

TEST_F(Pictures, ASurfaceIsSeenFromEverySide) {
  Actor plain = breasts();
  plain.arrows.clear();
  std::vector<Panel> panels;
  for (const View view :
       {View::Front, View::LeftOblique, View::RightOblique, View::Left, View::Right, View::Below}) {
    panels.push_back(panel_of(plain, view));
  }
  panels[1].diverging = true;
  const fs::path seen = folder_ / "seen.png", blank = folder_ / "blank.png";
  SANATRIX_DRAW([&] {
    write_picture(panels, 3, seen);
    for (Panel& panel : panels) {
      panel.actors = {nothing_in_the_same_place()};
    }
    write_picture(panels, 3, blank);
  });
  EXPECT_TRUE(is_png(seen));
  // Shaded colours do not compress; letters, words and the bar alone do.
  EXPECT_GT(fs::file_size(seen), 2 * fs::file_size(blank));
}

TEST_F(Pictures, ArrowsAndATranslucentSurfaceShowWhereTheBreastWas) {
  Actor ghost = breasts();
  ghost.opacity = 0.3;
  ghost.scalar.clear();
  const fs::path file = folder_ / "arrows.png";
  SANATRIX_DRAW([&] {
    write_picture({panel_of(ghost, View::Front), panel_of(ghost, View::Left)}, 2, file);
  });
  EXPECT_TRUE(is_png(file));
}

TEST_F(Pictures, ACutShowsTheInside) {
  TetMesh mesh = testing::cube(8, 0.1);
  check_and_orient(mesh, "cube");
  CutPanel cut{.mesh = &mesh,
               .points = mesh.points,
               .scalar = {},
               .plane_point = {0.05, 0.05, 0.05},
               .plane_normal = {0, 0, 1},
               .title = "Axial",
               .bar_title = "cells [%]",
               .bar_min = 0,
               .bar_max = 100};
  for (const Vec3& p : mesh.points) {
    cut.scalar.push_back(2000 * norm(p - Vec3{0.05, 0.05, 0.05}));
  }
  CutPanel oblique = cut;
  oblique.plane_normal = {0.3, 1, 0.2};
  const fs::path file = folder_ / "cut.png";
  SANATRIX_DRAW([&] { write_cuts({cut, oblique}, 2, file); });
  EXPECT_TRUE(is_png(file));
  cut.scalar.pop_back();
  EXPECT_THAT(with_display([&] { write_cuts({cut}, 1, file); }, quiet()).value_or(""),
              HasSubstr("a value for every vertex"));
}

TEST_F(Pictures, CurvesArePlotted) {
  Curve full{"large wound", {}, {}}, half{"small wound", {}, {}};
  for (int day = 0; day <= 60; ++day) {
    full.x.push_back(day);
    full.y.push_back(100 - 8 * (1 - std::exp(-day / 10.0)));
    half.x.push_back(day);
    half.y.push_back(100 - 5 * (1 - std::exp(-day / 6.0)));
  }
  const fs::path file = folder_ / "plot.png";
  SANATRIX_DRAW([&] {
    write_plot({full, half}, "Wound volume", "time [days]", "volume [%]", file);
  });
  EXPECT_TRUE(is_png(file));
}

TEST(OffScreenDisplay, AFailureInTheChildIsAReasonAndNotACrash) {
  EXPECT_THAT(with_display([] { require(false, "nothing to draw"); }, quiet()).value_or(""),
              ::testing::AnyOf(HasSubstr("nothing to draw"), HasSubstr("install Xvfb")));
  EXPECT_TRUE(with_display([] { std::abort(); }, quiet()).has_value());
}

TEST(OffScreenDisplay, AStopRequestEndsTheDrawingAtOnce) {
  std::stop_source stop;
  std::thread user([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stop.request_stop();
  });
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(with_display([] { std::this_thread::sleep_for(std::chrono::seconds(60)); },
                            quiet(stop.get_token())),
               Cancelled);
  user.join();
  // The child would have slept for a minute; half of it leaves room for a busy machine.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

TEST(OffScreenDisplay, WithoutXvfbTheReasonSaysWhatToInstall) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nonexistent", 1);
  const auto reason = with_display([] {}, quiet());
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(reason.value_or(""), HasSubstr("install Xvfb"));
}

}  // namespace
}  // namespace sanatrix::render

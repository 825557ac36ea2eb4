// One rank or two, the same bits. (Two schemes, one answer: case "explicit" of `sanatrix verify`.)
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/archive.hpp"
#include "fem/session.hpp"
#include "geometry/structured_mesh.hpp"
#include "healing/reaction_diffusion.hpp"

namespace sanatrix::healing {
namespace {

constexpr double day = 86400.0;

/// The octant of a wound of 10 mm radius in a ball of 30 mm.
struct ABall : ::testing::Test {
  TetMesh mesh = ball_octant(graded_radii(0.010, 5, 0.030, 1.4));
  std::vector<double> fraction = cells_where(mesh, [](const Vec3& p) { return norm(p) < 0.010; });
  std::unique_ptr<Model> model = make_model("vavourakis2016");
  Silent silent;
  Context ctx{"heal", silent};

  std::vector<double> state_after(double days, RdOptions options) {
    ReactionDiffusion rd(mesh, mesh.points, fraction, *model, options);
    rd.advance(days * day, ctx);
    return rd.state();
  }
};

const char* const child_file = "SANATRIX_TEST_STATE_FILE";

TEST_F(ABall, OnSeveralRanksChild) {
  const char* file = std::getenv(child_file);
  if (file == nullptr) {
    GTEST_SKIP() << "runs inside the test of two ranks";
  }
  ASSERT_EQ(fem::ranks(), 2);
  Archive archive;
  archive.reals["state"] = state_after(12.0, {});
  if (fem::rank() == 0) {
    archive.save(file);
  }
}

TEST_F(ABall, HealsTheSameToTheLastBitOnTwoRanks) {
  if (std::getenv(child_file) != nullptr || std::system("command -v mpirun > /dev/null") != 0) {
    GTEST_SKIP() << "needs mpirun";
  }
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  const auto file = std::filesystem::path(::testing::TempDir()) /
                    fmt::format("two_ranks_{}.archive", static_cast<long>(getpid()));
  // A clean environment: this process is itself an MPI program of one rank.
  const std::string command = fmt::format(
      "env -i PATH=\"$PATH\" HOME=\"$HOME\" HWLOC_COMPONENTS=-gl {}={} mpirun --allow-run-as-root "
      "--oversubscribe -n 2 {} --gtest_filter=ABall.OnSeveralRanksChild > {}.log 2>&1",
      child_file, file.string(), program.string(), file.string());
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const auto two = Archive::load(file).real("state");
  EXPECT_EQ(two, state_after(12.0, {}));
  std::filesystem::remove(file);
  std::filesystem::remove(file.string() + ".log");
}

}  // namespace
}  // namespace sanatrix::healing

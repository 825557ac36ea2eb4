// One rank with the whole mesh or several with a share each: the same healing to 1e-8. (Two
// schemes, one answer: case "explicit" of `sanatrix verify`.)
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/archive.hpp"
#include "fem/session.hpp"
#include "fem/transfer.hpp"
#include "geometry/structured_mesh.hpp"
#include "healing/reaction_diffusion.hpp"

namespace sanatrix::healing {
namespace {

constexpr double day = 86400.0;

/// The octant of a wound of 10 mm radius in a ball of 30 mm.
struct ABall : ::testing::Test {
  TetMesh mesh = ball_octant(graded_radii(0.010, 5, 0.030, 1.4));
  std::unique_ptr<Model> model = make_model("vavourakis2016");
  Silent silent;
  Context ctx{"heal", silent};

  /// Species at all vertices after six days, then what a history has of them; on rank 0.
  std::vector<double> healed(const fem::MeshShare* share) {
    const TetMesh& here = share == nullptr ? mesh : share->mesh();
    const auto fraction = cells_where(here, [](const Vec3& p) { return norm(p) < 0.010; });
    ReactionDiffusion rd(here, here.points, fraction, *model, {}, share);
    rd.advance(6.0 * day, ctx);
    const int species = static_cast<int>(model->species().size());
    std::vector<double> numbers =
        share == nullptr ? rd.state() : fem::vertex_transfer(*share).to_leader(rd.state(), species);
    const SpeciesRecord r = record(rd, here, here.points, fraction, *model);
    numbers.insert(numbers.end(), r.mean.begin(), r.mean.end());
    numbers.insert(numbers.end(), r.centre.begin(), r.centre.end());
    numbers.insert(numbers.end(), {r.eta_healthy_min, r.eta_healthy_max, r.far_field_second});
    return numbers;
  }
};

const char* const child_file = "SANATRIX_TEST_STATE_FILE";

TEST_F(ABall, OnSeveralRanksChild) {
  const char* file = std::getenv(child_file);
  if (file == nullptr) {
    GTEST_SKIP() << "runs inside the test of several ranks";
  }
  const fem::MeshShare share(mesh);
  ASSERT_LT(share.mesh().points.size(), mesh.points.size());
  Archive archive;
  archive.reals["healed"] = healed(&share);
  if (fem::rank() == 0) {
    archive.save(file);
  }
}

TEST_F(ABall, HealsTheSameOnThreeShares) {
  if (std::getenv(child_file) != nullptr || std::system("command -v mpirun > /dev/null") != 0) {
    GTEST_SKIP() << "needs mpirun";
  }
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  const auto file = std::filesystem::path(::testing::TempDir()) /
                    fmt::format("shares_{}.archive", static_cast<long>(getpid()));
  // A clean environment: this process is itself an MPI program of one rank.
  const std::string command = fmt::format(
      "env -i PATH=\"$PATH\" HOME=\"$HOME\" HWLOC_COMPONENTS=-gl OMP_NUM_THREADS=1 {}={} mpirun "
      "--allow-run-as-root --oversubscribe -n 3 {} --gtest_filter=ABall.OnSeveralRanksChild "
      "> {}.log 2>&1",
      child_file, file.string(), program.string(), file.string());
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const auto shares = Archive::load(file).real("healed");
  const auto one = healed(nullptr);
  ASSERT_EQ(shares.size(), one.size());
  double difference = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    difference = std::max(difference, std::abs(one[i] - shares[i]));
  }
  // Rounding of sums in another order, which step control carries on: 1e-10 after the six days that
  // lie between two mechanics steps. (In one go it reaches the tolerance of 1e-4 after some weeks.)
  EXPECT_LT(difference, 1e-8);
  std::filesystem::remove(file);
  std::filesystem::remove(file.string() + ".log");
}

}  // namespace
}  // namespace sanatrix::healing

// Element kernels and whole solves: `make bench`. Compare ratios within one run.
#include <benchmark/benchmark.h>

#include "fem/session.hpp"
#include "geometry/structured_mesh.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/problem.hpp"

namespace {

using namespace sanatrix;  // NOLINT(google-build-using-namespace): a program of its own
using namespace sanatrix::mechanics;

void cell_p1p1(benchmark::State& state) {
  const std::array<Vec3, 4> X{{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}};
  std::array<Vec3, 4> x = X;
  x[1][0] = 0.0103;
  std::array<double, 16> r{};
  std::array<double, 256> K{};
  const Unknown unknown = state.range(0) == 0 ? Unknown::Deformed : Unknown::Reference;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cell_element<4>({unknown, X, x, {}, Tissue{}, {0, 0, -9.81}}, r, K));
  }
}
BENCHMARK(cell_p1p1)->Arg(0)->Arg(1);

void skin_face(benchmark::State& state) {
  const std::array<Vec3, 3> X{{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}}};
  std::array<Vec3, 3> x = X;
  x[1][0] = 0.0103;
  std::array<double, 9> r{};
  std::array<double, 81> K{};
  for (auto _ : state) {
    face_element<3>({Unknown::Deformed, X, x, Skin{}, {0, 0, -9.81}}, r, K);
    benchmark::DoNotOptimize(K);
  }
}
BENCHMARK(skin_face);

/// One eighth of a ball held at its symmetry planes, pulled together by its core.
void gravity_free_contraction(benchmark::State& state) {
  constexpr double wound = 0.022;
  const TetMesh mesh =
      ball_octant(graded_radii(wound, static_cast<int>(state.range(0)), 3.0 * wound, 1.15));
  Body body;
  body.mesh = &mesh;
  body.fixed = symmetry_supports(mesh);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const bool wounded = norm(centroid(mesh, c)) < wound;
    body.tissue.push_back(wounded ? Tissue{200, 200, 1e4, 1000, 1, 830} : Tissue{});
  }
  Silent silent;
  Solver solver(body);
  for (auto _ : state) {
    benchmark::DoNotOptimize(solver.forward(mesh.points, {}, nullptr, Context("bench", silent)));
  }
  state.counters["vertices"] = static_cast<double>(mesh.points.size());
  state.counters["krylov"] = solver.last_report().krylov_iterations;
}
BENCHMARK(gravity_free_contraction)->Arg(8)->Arg(12)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  const fem::Session session;
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

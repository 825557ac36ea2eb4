// Element kernels and whole solves: `make bench`. Compare ratios within one run.
#include <benchmark/benchmark.h>

#include "fem/session.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/problem.hpp"
#include "octant_mesh.hpp"

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
  const TetMesh mesh =
      testing::octant_mesh({0.022, 0.066}, 1e-4 * static_cast<double>(state.range(0)),
                           4e-4 * static_cast<double>(state.range(0)));
  Body body;
  body.mesh = &mesh;
  body.fixed = testing::symmetry_supports(mesh);
  for (const int region : mesh.region) {
    body.tissue.push_back(region == 0 ? Tissue{200, 200, 1e4, 1000, 1, 830} : Tissue{});
  }
  Silent silent;
  Solver solver(body);
  for (auto _ : state) {
    benchmark::DoNotOptimize(solver.forward(mesh.points, {}, nullptr, Context("bench", silent)));
  }
  state.counters["vertices"] = static_cast<double>(mesh.points.size());
  state.counters["krylov"] = solver.last_report().krylov_iterations;
}
BENCHMARK(gravity_free_contraction)->Arg(30)->Arg(20)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  const fem::Session session;
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}

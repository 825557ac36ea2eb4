#include "verification/radial_wound.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace sanatrix::verification {
namespace {

struct Layer {
  double inner, outer;            // reference radii [m]
  double c1, c2, kappa, tension;  // [Pa]; tension: active second Piola-Kirchhoff stress
};

/// dW/d(stretch along the radius) and dW/d(stretch across it), both directions across together.
std::array<double, 2> stress(const Layer& layer, double along, double across) {
  const double J = along * across * across;
  const double I1 = along * along + 2.0 * across * across;
  const double I2 = across * across * across * across + 2.0 * along * along * across * across;
  const double j1 = std::pow(J, -2.0 / 3.0);
  const double j2 = j1 * j1;
  const auto derivative = [&](double dJ, double dI1, double dI2) {
    return layer.c1 * j1 * (dI1 - 2.0 / 3.0 * I1 / J * dJ) +
           layer.c2 * j2 * (dI2 - 4.0 / 3.0 * I2 / J * dJ) + layer.kappa * (J - 1.0) * dJ +
           0.5 * layer.tension * dI1;
  };
  return {derivative(across * across, 2.0 * along, 4.0 * along * across * across),
          derivative(2.0 * along * across, 4.0 * across,
                     4.0 * across * across * across + 4.0 * along * along * across)};
}

/// Forces of a layer on its inner and outer radius; one point suffices, as thick layers do not
/// occur.
std::array<double, 2> forces(const Layer& layer, double r_inner, double r_outer) {
  const double thickness = layer.outer - layer.inner;
  const double middle = 0.5 * (layer.outer + layer.inner);
  const double volume = (std::pow(layer.outer, 3) - std::pow(layer.inner, 3)) / 3.0;
  const auto [along, across] =
      stress(layer, (r_outer - r_inner) / thickness, 0.5 * (r_inner + r_outer) / middle);
  return {volume * (0.5 * across / middle - along / thickness),
          volume * (0.5 * across / middle + along / thickness)};
}

std::vector<Layer> layers_of(const RadialProfile& cells, double outer,
                             const healing::WoundMechanics& wound,
                             const mechanics::Tissue& healthy) {
  constexpr int in_wound = 400;
  constexpr double growth = 1.03;
  const double radius = cells.radius.back();
  std::vector<Layer> layers;
  for (int i = 0; i < in_wound; ++i) {
    const double inner = radius * i / in_wound;
    const double eta = std::max(cells.at(radius * (i + 0.5) / in_wound), 0.0);
    const double integrity = std::clamp(eta, wound.integrity_floor, 1.0);
    layers.push_back({inner, radius * (i + 1) / in_wound, integrity * wound.c1,
                      integrity * wound.c2, wound.kappa, wound.active_stress * eta});
  }
  for (double h = radius / in_wound; layers.back().outer < outer; h *= growth) {
    const double inner = layers.back().outer;
    layers.push_back(
        {inner, std::min(inner + h, outer), healthy.c1, healthy.c2, healthy.kappa, 0.0});
  }
  return layers;
}

/// Newton step for all radii: a tridiagonal system by elimination from the centre, which is held.
std::vector<double> newton_step(const std::vector<Layer>& layers, const std::vector<double>& r) {
  const std::size_t n = r.size();
  std::vector<double> below(n, 0.0);
  std::vector<double> diagonal(n, 0.0);
  std::vector<double> above(n, 0.0);
  std::vector<double> step(n, 0.0);
  const double probe = 1e-7 * r.back();
  for (std::size_t e = 0; e + 1 < n; ++e) {
    const auto at = forces(layers[e], r[e], r[e + 1]);
    const auto inner = forces(layers[e], r[e] + probe, r[e + 1]);
    const auto outer = forces(layers[e], r[e], r[e + 1] + probe);
    step[e] -= at[0];
    step[e + 1] -= at[1];
    diagonal[e] += (inner[0] - at[0]) / probe;
    above[e] += (outer[0] - at[0]) / probe;
    below[e + 1] += (inner[1] - at[1]) / probe;
    diagonal[e + 1] += (outer[1] - at[1]) / probe;
  }
  step[0] = above[0] = 0.0;
  diagonal[0] = 1.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double m = below[i] / diagonal[i - 1];
    diagonal[i] -= m * above[i - 1];
    step[i] -= m * step[i - 1];
  }
  step[n - 1] /= diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) {
    step[i] = (step[i] - above[i] * step[i + 1]) / diagonal[i];
  }
  return step;
}

}  // namespace

double RadialProfile::at(double r) const {
  const auto next = std::ranges::lower_bound(radius, r) - radius.begin();
  const auto i = std::clamp<std::ptrdiff_t>(next, 1, std::ssize(radius) - 1);
  const auto b = static_cast<std::size_t>(i);
  const double share = (r - radius[b - 1]) / (radius[b] - radius[b - 1]);
  return density[b - 1] + share * (density[b] - density[b - 1]);
}

double radial_volume_ratio(const RadialProfile& cells, double outer,
                           const healing::WoundMechanics& wound, const mechanics::Tissue& healthy) {
  ensure(cells.radius.size() > 1 && cells.radius.size() == cells.density.size(),
         "a profile of {} radii and {} densities", cells.radius.size(), cells.density.size());
  const std::vector<Layer> layers = layers_of(cells, outer, wound, healthy);
  std::vector<double> r{0.0};
  std::size_t wall = 0;
  for (const Layer& layer : layers) {
    wall = layer.outer <= cells.radius.back() * (1.0 + 1e-12) ? r.size() : wall;
    r.push_back(layer.outer);
  }
  for (int iteration = 0; iteration < 100; ++iteration) {
    const std::vector<double> step = newton_step(layers, r);
    double alpha = 1.0;
    const auto ordered = [&] {
      for (std::size_t i = 0; i + 1 < r.size(); ++i) {
        if (!(r[i + 1] + alpha * step[i + 1] > r[i] + alpha * step[i])) {
          return false;
        }
      }
      return true;
    };
    while (!ordered() && alpha > 1e-6) {
      alpha *= 0.5;
    }
    double most = 0.0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      r[i] += alpha * step[i];
      most = std::max(most, std::abs(step[i]));
    }
    if (most < 1e-9 * outer) {
      return std::pow(r[wall] / cells.radius.back(), 3);
    }
  }
  throw Error(Fault::Numerics, "the radial solution of a contracting wound did not converge",
              "this is a defect of the verification, not of a case: report it");
}

}  // namespace sanatrix::verification

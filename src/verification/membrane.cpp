// Homogeneous states of tissue and skin (VALIDATION.md C7), with slack and wrinkled directions.
#include "mechanics/membrane.hpp"

#include <cmath>

#include <fmt/format.h>

#include "geometry/structured_mesh.hpp"
#include "mechanics/elements.hpp"
#include "mechanics/mooney_rivlin.hpp"
#include "mechanics/problem.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

using mechanics::Element;
using mechanics::Skin;

const mechanics::Tissue c100{100.0, 100.0, 5e7, 1000.0, 1.0, 0.0};

/// Stretch along x of a block under the nominal traction that belongs to `stress` at `stretch`.
double block_stretch(Element element, double stress, double stretch, bool equibiaxial,
                     const Context& ctx) {
  const TetMesh mesh = block({0.01, 0.01, 0.01}, {2, 2, 2});
  mechanics::Body body;
  body.mesh = &mesh;
  body.element = element;
  body.tissue.assign(mesh.cells.size(), c100);
  body.fixed = symmetry_supports(mesh);
  for (const BoundaryFace& face : mesh.faces) {
    const std::string& name = mesh.boundary_names[static_cast<std::size_t>(face.name)];
    if (name == "x1" || (equibiaxial && name == "y1")) {
      body.loads.traction_faces.push_back(face);
    }
  }
  body.loads.traction = [=](const Vec3& X) {
    const double t = stress / stretch;
    return X[0] > X[1] ? Vec3{t, 0.0, 0.0} : Vec3{0.0, t, 0.0};  // on x1, on y1
  };
  mechanics::Solver solver(body);
  const auto shape = solver.forward(solver.straight_nodes(mesh.points), {}, nullptr, ctx);
  const auto corner = static_cast<std::size_t>(vertices_on(mesh, "x1").front());
  return shape.nodes[corner][0] / mesh.points[corner][0];
}

Findings tissue_states(const Context& ctx) {
  Findings found;
  const double l = 1.2;
  for (const bool biaxial : {false, true}) {
    const double reference = biaxial ? 467.38 : 222.44;
    const double across = biaxial ? 1.0 / (l * l) : 1.0 / std::sqrt(l);
    const Mat3 F{{{l, 0, 0}, {0, biaxial ? l : across, 0}, {0, 0, across}}};
    const auto s = mechanics::stress(c100, F, 0.0);
    const char* name = biaxial ? "equibiaxial" : "uniaxial";
    found.checks.push_back(near(fmt::format("{} stress at 1.2", name), reference,
                                s.P[0][0] * l - s.P[2][2] * across, 0.005, "Pa",
                                "reference given to 0.01"));
    for (const Element element : {Element::P1P1, Element::P2P1}) {
      found.checks.push_back(near(fmt::format("{} stretch of a block, {}", name, title_of(element)),
                                  l, block_stretch(element, reference, l, biaxial, ctx), 1e-4, "",
                                  "homogeneous: exact up to the reference's digits and 1/kappa"));
    }
  }
  return found;
}

/// In-plane Cauchy stresses of the skin [Pa] from the nodal forces of one triangle: the force
/// per reference length on the two legs, divided by the deformed thickness.
struct SkinStress {
  double along, across;
};
template <std::size_t Nodes>
SkinStress skin_stress(const Skin& skin, double l1, double l2) {
  const double a = 0.01;
  std::vector<Vec3> reference{{0, 0, 0}, {a, 0, 0}, {0, a, 0}};
  if (Nodes == 6) {
    reference.insert(reference.end(), {{0.5 * a, 0, 0}, {0.5 * a, 0.5 * a, 0}, {0, 0.5 * a, 0}});
  }
  std::vector<Vec3> deformed;
  for (const Vec3& X : reference) {
    deformed.push_back({l1 * X[0], l2 * X[1], 0.0});
  }
  std::vector<double> force(3 * Nodes);
  mechanics::face_element<Nodes>(
      {mechanics::Unknown::Deformed, reference, deformed, skin, {}, false}, force, {});
  // Virtual work of an affine displacement: sum f . (e X) = area N : e, N nominal tension [N/m].
  double work1 = 0.0;
  double work2 = 0.0;
  for (std::size_t n = 0; n < Nodes; ++n) {
    work1 += force[3 * n] * reference[n][0];
    work2 += force[3 * n + 1] * reference[n][1];
  }
  const double area = 0.5 * a * a;
  return {l1 * work1 / (area * skin.thickness), l2 * work2 / (area * skin.thickness)};
}

/// 2 (l^2 - 1/l)(alpha beta e^(beta (I1 - 3)) + c2/l)
double uniaxial_stress(const Skin& s, double l) {
  const double I1 = l * l + 2.0 / l;
  return 2.0 * (l * l - 1.0 / l) * (s.alpha * s.beta * std::exp(s.beta * (I1 - 3.0)) + s.c2 / l);
}

double equibiaxial_stress(const Skin& s, double l) {
  const double I1 = 2.0 * l * l + std::pow(l, -4);
  return 2.0 * (l * l - std::pow(l, -4)) *
         (s.alpha * s.beta * std::exp(s.beta * (I1 - 3.0)) + s.c2 * l * l);
}

template <std::size_t Nodes>
void add_skin_states(Findings& found, const std::string& element) {
  const Skin skin;
  for (const double l : {1.1, 1.2}) {
    const SkinStress uniaxial = skin_stress<Nodes>(skin, l, 1.0 / std::sqrt(l));
    const SkinStress biaxial = skin_stress<Nodes>(skin, l, l);
    const double expected = uniaxial_stress(skin, l);
    found.checks.push_back(near(fmt::format("{}, uniaxial {}", element, l), 1e-3 * expected,
                                1e-3 * uniaxial.along, 1e-9 * expected, "kPa", "closed form"));
    found.checks.push_back(near(fmt::format("{}, uniaxial {}, across", element, l), 0.0,
                                uniaxial.across, 1e-9 * expected, "Pa", "free edge"));
    found.checks.push_back(near(fmt::format("{}, equibiaxial {}", element, l),
                                1e-3 * equibiaxial_stress(skin, l), 1e-3 * biaxial.along,
                                1e-9 * equibiaxial_stress(skin, l), "kPa", "closed form"));
    // Wrinkled: narrower than its natural width, the membrane stays in uniaxial tension.
    const SkinStress wrinkled = skin_stress<Nodes>(skin, l, 0.7);
    found.checks.push_back(near(fmt::format("{}, wrinkled {} x 0.7, along", element, l),
                                1e-3 * expected, 1e-3 * wrinkled.along, 1e-9 * expected, "kPa",
                                "tension field: as uniaxial"));
    found.checks.push_back(near(fmt::format("{}, wrinkled {} x 0.7, across", element, l), 0.0,
                                wrinkled.across, 1e-9 * expected, "Pa", "no compression"));
  }
  const SkinStress slack = skin_stress<Nodes>(skin, 0.95, 0.9);
  found.checks.push_back(near(element + ", slack in both directions", 0.0,
                              std::abs(slack.along) + std::abs(slack.across), 1e-12, "Pa",
                              "slack"));
  Skin full = skin;
  full.tension_field = false;
  found.checks.push_back(within(element + ", without tension field: compression", -1e9, -1.0,
                                skin_stress<Nodes>(full, 0.95, 0.9).along, "Pa",
                                "the relaxation is what removes it"));
}

Findings skin_states(const Context&) {
  Findings found;
  const Skin skin;
  for (const auto& [l, uniaxial, biaxial] :
       {std::array{1.1, 8.3, 22.4}, std::array{1.2, 31.1, 207.5}}) {
    found.checks.push_back(near(fmt::format("uniaxial formula at {}", l), uniaxial,
                                1e-3 * uniaxial_stress(skin, l), 0.05, "kPa",
                                "reference given to 0.1 kPa"));
    found.checks.push_back(near(fmt::format("equibiaxial formula at {}", l), biaxial,
                                1e-3 * equibiaxial_stress(skin, l), 0.05, "kPa",
                                "reference given to 0.1 kPa"));
  }
  add_skin_states<3>(found, "linear triangle");
  add_skin_states<6>(found, "quadratic triangle");
  return found;
}

}  // namespace

void add_membrane(std::vector<Case>& cases) {
  cases.push_back({"homogeneous-tissue", "Homogeneous states of tissue (C7)",
                   Chapter::CodeVerification, Cost::Fast,
                   "Mooney-Rivlin, c1 = c2 = 100 Pa, uniaxial and equibiaxial tension: the law's "
                   "stress, and a block of tetrahedra under the traction of the closed form.",
                   tissue_states});
  cases.push_back({"homogeneous-skin", "Homogeneous states of the skin, slack directions (C7)",
                   Chapter::CodeVerification, Cost::Fast,
                   "Veronda-Westmann membrane of the default preset: taut, wrinkled and slack "
                   "states from the nodal forces of the shipped skin elements.",
                   skin_states});
}

}  // namespace sanatrix::verification

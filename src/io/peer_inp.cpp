// Abaqus and CalculiX input: C3D4 or C3D10, Mooney-Rivlin, gravity, one static step with large
// displacements.
#include <fmt/format.h>

#include "io/peer_nodes.hpp"

namespace sanatrix::io {
namespace {

/// Lines of at most 12 numbers, as the format asks for.
std::string number_lines(const std::vector<int>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    text +=
        fmt::format("{}{}", numbers[i], (i + 1) % 12 == 0 || i + 1 == numbers.size() ? "\n" : ", ");
  }
  return text;
}

std::string elements(const PeerModel& model, const PeerNodes& nodes) {
  std::string text;
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    text += fmt::format("*ELEMENT, TYPE={}, ELSET={}\n", model.order == 2 ? "C3D10" : "C3D4",
                        model.materials[m].name);
    for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
      if (model.mesh.region[c] != static_cast<int>(m)) {
        continue;
      }
      text += fmt::format("{}", c + 1);
      for (const int n : nodes.cells[c]) {
        text += fmt::format(",{}", n + 1);
      }
      text += '\n';
    }
  }
  return text;
}

std::string materials(const PeerModel& model) {
  std::string text;
  for (const PeerMaterial& m : model.materials) {
    // U = 1/D1 (J - 1)^2
    text += fmt::format(
        "*MATERIAL, NAME=M_{0}\n*HYPERELASTIC, MOONEY-RIVLIN\n{1:.9g}, {2:.9g}, {3:.9g}\n"
        "*DENSITY\n{4:.9g}\n*SOLID SECTION, ELSET={0}, MATERIAL=M_{0}\n",
        m.name, m.c1, m.c2, 2.0 / m.kappa, m.density);
  }
  return text;
}

std::string sets(const PeerModel& model, const PeerNodes& nodes) {
  std::string text;
  std::vector<int> vertices;
  for (std::size_t v = 0; v < model.mesh.points.size(); ++v) {
    vertices.push_back(static_cast<int>(v) + 1);
  }
  text += "*NSET, NSET=VERTICES\n" + number_lines(vertices);
  for (std::size_t b = 0; b < model.mesh.boundary_names.size(); ++b) {
    std::vector<bool> on(nodes.points.size(), false);
    for (const BoundaryFace& face : model.mesh.faces) {
      for (const int n :
           face.name == static_cast<int>(b) ? nodes.face(face.vertex) : std::vector<int>{}) {
        on[static_cast<std::size_t>(n)] = true;
      }
    }
    std::vector<int> numbers;
    for (std::size_t n = 0; n < on.size(); ++n) {
      if (on[n]) {
        numbers.push_back(static_cast<int>(n) + 1);
      }
    }
    if (!numbers.empty()) {
      text +=
          fmt::format("*NSET, NSET=N_{}\n", model.mesh.boundary_names[b]) + number_lines(numbers);
    }
  }
  text += "*ELSET, ELSET=ALL_CELLS\n";
  for (const PeerMaterial& m : model.materials) {
    text += m.name + "\n";
  }
  return text;
}

}  // namespace

std::string inp_text(const PeerModel& model) {
  const PeerNodes nodes = make_peer_nodes(model);
  std::string text = fmt::format("** {}\n** SI units: m, Pa, kg/m3\n", model.title);
  for (const std::string& note : model.notes) {
    text += fmt::format("** {}\n", note);
  }
  if (!model.membranes.empty()) {
    text += "** the skin is left out: neither program has a Veronda-Westmann membrane\n";
  }
  text += "*NODE, NSET=ALL_NODES\n";
  for (std::size_t n = 0; n < nodes.points.size(); ++n) {
    const Vec3& p = nodes.points[n];
    text += fmt::format("{},{:.12g},{:.12g},{:.12g}\n", n + 1, p[0], p[1], p[2]);
  }
  text += elements(model, nodes) + sets(model, nodes) + materials(model);
  text += "*BOUNDARY\n";
  for (std::size_t n = 0; n < nodes.fixed.size(); ++n) {
    for (int i = 0; i < 3; ++i) {
      if ((nodes.fixed[n] >> i & 1) != 0) {
        text += fmt::format("{},{},{}\n", n + 1, i + 1, i + 1);
      }
    }
  }
  const double g = norm(model.gravity);
  const Vec3 down = g > 0.0 ? (1.0 / g) * model.gravity : Vec3{0.0, 0.0, -1.0};
  text += fmt::format(
      "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.\n*DLOAD\nALL_CELLS, GRAV, {:.9g}, {:.12g}, "
      "{:.12g}, "
      "{:.12g}\n*NODE FILE\nU\n*NODE PRINT, NSET=VERTICES, FREQUENCY=1000\nU\n*END STEP\n",
      g, down[0], down[1], down[2]);
  return text;
}

}  // namespace sanatrix::io

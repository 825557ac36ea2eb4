// FEBio 4 input: tet4 or tet10, Mooney-Rivlin with the pressure of kappa/2 (J - 1)^2, the skin as
// thin Veronda-Westmann shells, gravity as a ramped body force.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"
#include "io/peer_nodes.hpp"

namespace sanatrix::io {
namespace {

std::string joined(const std::vector<int>& nodes) {
  std::string text;
  for (const int n : nodes) {
    text += fmt::format("{}{}", text.empty() ? "" : ",", n + 1);
  }
  return text;
}

std::string materials(const PeerModel& model) {
  std::string text = "  <Material>\n";
  int id = 0;
  for (const PeerMaterial& m : model.materials) {
    text += fmt::format(
        "    <material id=\"{}\" name=\"{}\" type=\"Mooney-Rivlin\">\n      "
        "<density>{:.9g}</density>\n"
        "      <c1>{:.9g}</c1><c2>{:.9g}</c2><k>{:.9g}</k>\n"
        "      <pressure_model>2</pressure_model>\n    </material>\n",
        ++id, m.name, m.density, m.c1, m.c2, m.kappa);
  }
  for (const PeerMembrane& m : model.membranes) {
    // FEBio's law has c2 = -alpha beta/2 built in; near incompressibility by a large bulk modulus.
    text += fmt::format(
        "    <material id=\"{}\" name=\"{}\" type=\"Veronda-Westmann\">\n"
        "      <density>{:.9g}</density>\n      <c1>{:.9g}</c1><c2>{:.9g}</c2><k>{:.9g}</k>\n"
        "    </material>\n",
        ++id, m.name, m.density, m.alpha, m.beta, 100.0 * m.alpha * m.beta);
  }
  return text + "  </Material>\n";
}

std::string mesh(const PeerModel& model, const PeerNodes& nodes) {
  std::string text = "  <Mesh>\n    <Nodes name=\"all\">\n";
  for (std::size_t n = 0; n < nodes.points.size(); ++n) {
    const Vec3& p = nodes.points[n];
    text += fmt::format("      <node id=\"{}\">{:.12g},{:.12g},{:.12g}</node>\n", n + 1, p[0], p[1],
                        p[2]);
  }
  text += "    </Nodes>\n";
  int id = 0;
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    text += fmt::format("    <Elements type=\"{}\" name=\"{}\">\n",
                        model.order == 2 ? "tet10" : "tet4", model.materials[m].name);
    for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
      if (model.mesh.region[c] == static_cast<int>(m)) {
        text += fmt::format("      <elem id=\"{}\">{}</elem>\n", ++id, joined(nodes.cells[c]));
      }
    }
    text += "    </Elements>\n";
  }
  for (const PeerMembrane& m : model.membranes) {
    text += fmt::format("    <Elements type=\"{}\" name=\"{}\">\n",
                        model.order == 2 ? "tri6" : "tri3", m.name);
    for (const auto& face : m.faces) {
      text += fmt::format("      <elem id=\"{}\">{}</elem>\n", ++id, joined(nodes.face(face)));
    }
    text += "    </Elements>\n";
  }
  for (std::size_t b = 0; b < model.mesh.boundary_names.size(); ++b) {
    text += fmt::format("    <Surface name=\"{}\">\n", model.mesh.boundary_names[b]);
    int face_id = 0;
    for (const BoundaryFace& face : model.mesh.faces) {
      if (face.name == static_cast<int>(b)) {
        text += fmt::format("      <{0} id=\"{1}\">{2}</{0}>\n", model.order == 2 ? "tri6" : "tri3",
                            ++face_id, joined(nodes.face(face.vertex)));
      }
    }
    text += "    </Surface>\n";
  }
  for (int bits = 1; bits < 8; ++bits) {
    std::vector<int> held;
    for (std::size_t n = 0; n < nodes.fixed.size(); ++n) {
      if (nodes.fixed[n] == bits) {
        held.push_back(static_cast<int>(n));
      }
    }
    if (!held.empty()) {
      text += fmt::format("    <NodeSet name=\"held_{}\">{}</NodeSet>\n", bits, joined(held));
    }
  }
  return text + "  </Mesh>\n";
}

std::string domains(const PeerModel& model) {
  std::string text = "  <MeshDomains>\n";
  for (const PeerMaterial& m : model.materials) {
    text += fmt::format("    <SolidDomain name=\"{0}\" mat=\"{0}\"/>\n", m.name);
  }
  for (const PeerMembrane& m : model.membranes) {
    text += fmt::format(
        "    <ShellDomain name=\"{0}\" mat=\"{0}\" type=\"elastic-shell\">\n"
        "      <shell_thickness>{1:.9g}</shell_thickness>\n    </ShellDomain>\n",
        m.name, m.thickness);
  }
  return text + "  </MeshDomains>\n";
}

std::string supports(const PeerModel& model, const PeerNodes& nodes) {
  std::string text = "  <Boundary>\n";
  for (int bits = 1; bits < 8; ++bits) {
    if (std::ranges::find(nodes.fixed, bits) == nodes.fixed.end()) {
      continue;
    }
    text += fmt::format(
        "    <bc name=\"held_{0}\" node_set=\"held_{0}\" type=\"zero displacement\">\n"
        "      <x_dof>{1}</x_dof><y_dof>{2}</y_dof><z_dof>{3}</z_dof>\n    </bc>\n",
        bits, bits & 1, bits >> 1 & 1, bits >> 2 & 1);
    if (!model.membranes.empty()) {
      text += fmt::format(
          "    <bc name=\"held_shell_{0}\" node_set=\"held_{0}\" type=\"zero shell "
          "displacement\">\n"
          "      <sx_dof>{1}</sx_dof><sy_dof>{2}</sy_dof><sz_dof>{3}</sz_dof>\n    </bc>\n",
          bits, bits & 1, bits >> 1 & 1, bits >> 2 & 1);
    }
  }
  return text + "  </Boundary>\n";
}

constexpr auto control = R"(  <Module type="solid"/>
  <Control>
    <analysis>STATIC</analysis>
    <time_steps>10</time_steps>
    <step_size>0.1</step_size>
    <solver type="solid">
      <symmetric_stiffness>symmetric</symmetric_stiffness>
      <dtol>1e-6</dtol>
      <etol>1e-8</etol>
      <qn_method type="BFGS"><max_ups>0</max_ups></qn_method>
    </solver>
    <time_stepper type="default">
      <max_retries>10</max_retries>
      <opt_iter>15</opt_iter>
      <dtmin>0.001</dtmin>
      <dtmax>0.2</dtmax>
      <aggressiveness>1</aggressiveness>
    </time_stepper>
  </Control>
)";

constexpr auto ramp_and_output = R"(  <LoadData>
    <load_controller id="1" type="loadcurve">
      <interpolate>LINEAR</interpolate>
      <points><pt>0,0</pt><pt>1,1</pt></points>
    </load_controller>
  </LoadData>
  <Output>
    <plotfile type="febio"><var type="displacement"/><var type="stress"/></plotfile>
    <logfile><node_data data="ux;uy;uz" delim="," name="displacement"/></logfile>
  </Output>
</febio_spec>
)";

}  // namespace

std::string feb_text(const PeerModel& model) {
  for (const PeerMembrane& m : model.membranes) {
    require(
        std::abs(m.c2 + 0.5 * m.alpha * m.beta) <= 1e-3 * m.alpha * m.beta,
        "skin '{}': FEBio's Veronda-Westmann law has c2 = -alpha beta/2 = {:.6g} Pa, not {:.6g}",
        m.name, -0.5 * m.alpha * m.beta, m.c2);
  }
  const PeerNodes nodes = make_peer_nodes(model);
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<febio_spec version=\"4.0\">\n<!-- {}; SI units "
      "-->\n",
      model.title);
  for (const std::string& note : model.notes) {
    text += fmt::format("<!-- {} -->\n", note);
  }
  if (!model.membranes.empty()) {
    text += "<!-- the skin is a thin shell here: it bears compression and some bending -->\n";
  }
  text += control + materials(model) + mesh(model, nodes) + domains(model) + supports(model, nodes);
  // FEBio subtracts body forces: what it is given is against gravity. [per mass]
  text += fmt::format(
      "  <Loads>\n    <body_load type=\"body force\">\n"
      "      <force lc=\"1\">{:.9g},{:.9g},{:.9g}</force>\n    </body_load>\n  </Loads>\n",
      -model.gravity[0], -model.gravity[1], -model.gravity[2]);
  return text + ramp_and_output;
}

}  // namespace sanatrix::io

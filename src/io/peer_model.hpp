// A mechanical model as other programs read it: Gmsh, ParaView, FEBio 4, Abaqus and CalculiX.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::io {

/// c1 (I1bar - 3) + c2 (I2bar - 3) + kappa/2 (J - 1)^2. [Pa, kg/m3]
struct PeerMaterial {
  std::string name;  ///< letters, digits, - and _; also the name of its set of cells
  double c1, c2, kappa, density;
};

/// Veronda-Westmann membrane on a boundary. [Pa, m, kg/m3]
struct PeerMembrane {
  std::string name;      ///< as a material's
  std::string boundary;  ///< of the mesh; empty when it covers only a part of one
  double alpha, beta, c2, thickness, density;
  bool tension_field;                       ///< bears no compression in Sanatrix
  std::vector<std::array<int, 3>> faces{};  ///< vertices
};

struct PeerModel {
  std::string title;  ///< one line
  TetMesh mesh;       ///< vertices in the stress-free shape; its regions are the materials
  std::vector<PeerMaterial> materials;  ///< per region
  std::vector<PeerMembrane> membranes;
  std::vector<std::uint8_t> fixed;  ///< per vertex: bit 0 x, bit 1 y, bit 2 z held
  Vec3 gravity{};                   ///< [m/s2]
  int order = 1;                    ///< 2: straight-sided quadratic cells
  std::string element = "p1p1";     ///< of Sanatrix, whose shape this is
  std::vector<std::string> notes;   ///< what a reader of the file has to know
};

enum class PeerFormat { Msh, Vtu, Feb, Inp };
/// Whole or not at all. SI throughout. Error{Resource} when it cannot be written.
void write_peer(const PeerModel& model, PeerFormat format, const std::filesystem::path& file);

}  // namespace sanatrix::io

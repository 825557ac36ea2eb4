// One mesh in every encoding of Gmsh files, whole, cut anywhere and with any byte changed.
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "io/mesh_file.hpp"
#include "own_folder.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

/// Writes numbers as words or as bytes.
class Writer {
 public:
  explicit Writer(bool is_binary) : is_binary_(is_binary) {}
  Writer& text(const std::string& words) {
    all_ += words;
    return *this;
  }
  template <class T>
  Writer& many(std::initializer_list<T> values) {
    for (const T value : values) {
      is_binary_ ? all_.append(reinterpret_cast<const char*>(&value), sizeof value)
                 : all_.append(fmt::format("{} ", value));
    }
    return *this;
  }
  Writer& ints(std::initializer_list<int> values) { return many(values); }
  Writer& sizes(std::initializer_list<std::size_t> values) { return many(values); }
  Writer& doubles(std::initializer_list<double> values) { return many(values); }
  [[nodiscard]] const std::string& all() const { return all_; }

 private:
  bool is_binary_;
  std::string all_;
};

void begin(Writer& w, const char* version, bool is_binary) {
  w.text(fmt::format("$MeshFormat\n{} {} 8\n", version, is_binary ? 1 : 0));
  if (is_binary) {
    w.ints({1}).text("\n");
  }
  w.text(
      "$EndMeshFormat\n$Comments\nany thing $ 7\n$EndComments\n$PhysicalNames\n3\n"
      "3 7 \"fat tissue\"\n2 8 \"base\"\n0 4 \"rim\"\n$EndPhysicalNames\n");
}

/// Two tetrahedra, the second first, on a face in two groups; two points in one; a line; a node
/// that is not used. Numbers have gaps.
std::string msh22(bool is_binary) {
  Writer w(is_binary);
  begin(w, "2.2", is_binary);
  w.text("$Nodes\n6\n");
  w.ints({10}).doubles({0, 0, 0}).ints({2}).doubles({1, 0, 0}).ints({3}).doubles({0, 1, 0});
  w.ints({4}).doubles({0, 0, 1}).ints({5}).doubles({0, 0, -1}).ints({66}).doubles({9, 9, 9});
  w.text("\n$EndNodes\n$Elements\n7\n");
  int number = 0;
  const auto element = [&](int type, int group, int entity, std::initializer_list<int> nodes) {
    ++number;
    is_binary ? w.ints({type, 1, 3, number}) : w.ints({number, type, 3});
    w.ints({group, entity, 0}).ints(nodes).text(is_binary ? "" : "\r\n");
  };
  element(4, 9, 2, {10, 2, 3, 5});
  element(4, 7, 1, {10, 2, 3, 4});
  element(1, 0, 1, {10, 2});
  element(2, 8, 1, {10, 2, 4});
  element(2, 11, 1, {10, 2, 4});
  element(15, 4, 3, {3});
  element(15, 4, 1, {5});
  return w.text("\n$EndElements\n").all();
}

std::string msh41(bool is_binary) {
  Writer w(is_binary);
  begin(w, "4.1", is_binary);
  w.text("$Entities\n").sizes({2, 1, 1, 2});
  w.ints({1}).doubles({0, 0, -1}).sizes({1}).ints({4});
  w.ints({3}).doubles({0, 1, 0}).sizes({1}).ints({4});
  w.ints({1}).doubles({0, 0, 0, 1, 0, 0}).sizes({0, 2}).ints({1, -2});
  w.ints({1}).doubles({0, 0, 0, 1, 0, 1}).sizes({2}).ints({-8, 11}).sizes({1}).ints({1});
  w.ints({1}).doubles({0, 0, 0, 1, 1, 1}).sizes({1}).ints({7}).sizes({0});
  w.ints({2}).doubles({0, 0, -1, 1, 1, 0}).sizes({1}).ints({9}).sizes({0});
  w.text("\n$EndEntities\n$Nodes\n").sizes({2, 6, 2, 66});
  w.ints({2, 1, 1}).sizes({1, 10}).doubles({0, 0, 0, 0.25, 0.75});  // with its parameters
  w.ints({3, 1, 0}).sizes({5, 2, 3, 4, 5, 66});
  w.doubles({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 9, 9, 9});
  w.text("\n$EndNodes\n$Elements\n").sizes({6, 6, 1, 6});
  w.ints({3, 2, 4}).sizes({1, 1, 10, 2, 3, 5}).ints({3, 1, 4}).sizes({1, 2, 10, 2, 3, 4});
  w.ints({1, 1, 1}).sizes({1, 3, 10, 2}).ints({2, 1, 2}).sizes({1, 4, 10, 2, 4});
  w.ints({0, 3, 15}).sizes({1, 5, 3}).ints({0, 1, 15}).sizes({1, 6, 5});
  return w.text("\n$EndElements\n").all();
}

/// By format and whether it is binary.
class MshFile : public ::testing::TestWithParam<std::tuple<double, bool>> {
 protected:
  ~MshFile() override { fs::remove_all(folder_); }

  /// Not flushed to disk, unlike write_text: there are thousands.
  TetMesh read(const std::string& bytes) const {
    std::ofstream(folder_ / "a.msh", std::ios::binary) << bytes;
    return read_msh(folder_ / "a.msh", LengthUnit::Metre);
  }
  /// Whether it was read; anything thrown but a fault of the input fails the test.
  bool survives(const std::string& bytes) const {
    try {
      read(bytes);
      return true;
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::Input) << e.what();
      EXPECT_THAT(e.what(), HasSubstr("a.msh"));
      return false;
    }
  }
  fs::path folder_ = testing::own_folder();
  const std::string whole_ = std::get<0>(GetParam()) == 2.2 ? msh22(std::get<1>(GetParam()))
                                                            : msh41(std::get<1>(GetParam()));
};

TEST_P(MshFile, GivesTheSameMeshInEveryEncoding) {
  const TetMesh mesh = read(whole_);
  // Vertices as volumes use them, volumes and points by their tags.
  EXPECT_THAT(mesh.points, ElementsAre(Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1},
                                       Vec3{0, 0, -1}));
  EXPECT_THAT(mesh.cells, ElementsAre(std::array{0, 1, 2, 3}, std::array{0, 1, 4, 2}));
  EXPECT_THAT(mesh.region, ElementsAre(0, 1));
  EXPECT_THAT(mesh.region_names, ElementsAre("fat tissue", "region_9"));
  EXPECT_THAT(mesh.boundary_names, ElementsAre("base", "boundary_11"));
  ASSERT_EQ(mesh.faces.size(), 2U);  // once for each of its groups
  for (const int name : {0, 1}) {
    EXPECT_EQ(mesh.faces[static_cast<std::size_t>(name)].name, name);
    EXPECT_THAT(mesh.faces[static_cast<std::size_t>(name)].vertex,
                ::testing::UnorderedElementsAre(0, 1, 3));
  }
  EXPECT_THAT(mesh.named_points, ElementsAre(Pair("rim_1", 4), Pair("rim_2", 2)));
}

TEST_P(MshFile, IsRefusedWhereverItIsCut) {
  for (std::size_t length = 0; length < whole_.rfind("$EndElements") + 12; ++length) {
    EXPECT_FALSE(survives(whole_.substr(0, length))) << length;
  }
}

TEST_P(MshFile, IsReadOrRefusedWhateverByteIsChanged) {
  std::mt19937 random(1);
  for (std::size_t at = 0; at < whole_.size(); ++at) {
    std::string bytes = whole_;
    for (const unsigned change : {0U, 0x7FU, 0xFFU, unsigned{'9'}, unsigned(random()) % 256}) {
      bytes[at] = static_cast<char>(change);
      survives(bytes);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Gmsh, MshFile,
                         ::testing::Combine(::testing::Values(2.2, 4.1), ::testing::Bool()));

}  // namespace
}  // namespace sanatrix::io

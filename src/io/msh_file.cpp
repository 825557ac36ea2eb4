// The sections of a Gmsh file, by the formats' description in Gmsh's reference manual. Counts and
// numbers are the file's own: nothing is reserved or skipped on their word.
#include "io/msh_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Walks through a file: words and numbers of text, and numbers as they lie in memory.
class Scanner {
 public:
  explicit Scanner(const fs::path& file) : name_(file.string()), text_(read_text(file)) {}

  void set_binary() { binary_ = true; }
  [[nodiscard]] bool binary() const { return binary_; }

  [[noreturn]] void fail(const std::string& cause) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<long>(at_), '\n');
    throw Error(Fault::Input,
                binary_ ? fmt::format("cannot read mesh {}: byte {}: {}", name_, at_, cause)
                        : fmt::format("cannot read mesh {}: line {}: {}", name_, line, cause),
                "save it again from Gmsh as format 4.1 or 2.2");
  }

  /// Empty at the end.
  std::string_view word() {
    skip_blanks();
    const std::size_t end = std::min(text_.find_first_of(blanks, at_), text_.size());
    const std::string_view found = std::string_view(text_).substr(at_, end - at_);
    at_ = end;
    return found;
  }

  template <class T>
  T text_number() {
    skip_blanks();
    at_ += at_ < text_.size() && text_[at_] == '+' ? 1 : 0;  // which from_chars does not know
    T value{};
    const char* const end = text_.data() + text_.size();
    const auto [stopped, error] = std::from_chars(text_.data() + at_, end, value);
    if (error != std::errc{}) {
      fail(at_ == text_.size() ? "the file ends here" : "a number should stand here");
    }
    at_ = static_cast<std::size_t>(stopped - text_.data());
    return value;
  }

  template <class T>
  T number() {
    if (!binary_) {
      return text_number<T>();
    }
    if (text_.size() - at_ < sizeof(T)) {
      fail("the file ends here");
    }
    T value;
    std::memcpy(&value, text_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  template <class T>
  void skip(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      number<T>();
    }
  }

  void end_line() { at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1; }

  /// The next text between quotes, in this line.
  std::string_view quoted() {
    const std::string_view line = std::string_view(text_).substr(0, text_.find('\n', at_));
    const std::size_t open = line.find('"', at_);
    const std::size_t close = open == line.npos ? open : line.find('"', open + 1);
    if (close == line.npos) {
      fail("a name in quotes is missing");
    }
    at_ = close + 1;
    return line.substr(open + 1, close - open - 1);
  }

  void skip_past(std::string_view mark) {
    const std::size_t found = text_.find(mark, at_);
    if (found == std::string::npos) {
      fail(fmt::format("{} is missing", mark));
    }
    at_ = found + mark.size();
  }

 private:
  static constexpr std::string_view blanks = " \t\r\n";

  void skip_blanks() { at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size()); }

  std::string name_, text_;
  std::size_t at_ = 0;
  bool binary_ = false;
};

struct ElementKind {
  int dimension, nodes;
};
class Parser {
 public:
  explicit Parser(const fs::path& file) : in_(file) {}

  MshFile read() {
    read_format();
    for (std::string section(in_.word()); !section.empty(); section = in_.word()) {
      if (!section.starts_with('$')) {
        in_.fail("a section should begin here, with $ and its name");
      }
      in_.end_line();
      const std::string end = "$End" + section.substr(1);
      if (section == "$PhysicalNames") {
        read_names();
      } else if (section == "$Entities") {
        read_entities();
      } else if (section == "$Nodes") {
        is_4_ ? read_nodes_4() : read_nodes_2(false);
      } else if (section == "$ParametricNodes") {
        read_nodes_2(true);
      } else if (section == "$Elements") {
        is_4_ ? read_elements_4() : read_elements_2();
      } else if (section == "$PartitionedEntities") {
        in_.fail("the mesh is partitioned, which is not read");
      } else {
        in_.skip_past(end);
        continue;
      }
      require_word(end);
    }
    return std::move(found_);
  }

 private:
  void read_format() {
    if (in_.word() != "$MeshFormat") {
      in_.fail("this is not a Gmsh mesh, which begins with $MeshFormat");
    }
    const auto version = in_.text_number<double>();
    const int is_binary = in_.text_number<int>(), size = in_.text_number<int>();
    is_4_ = version == 4.1;
    if (!is_4_ && (version < 2 || version >= 3)) {
      in_.fail(fmt::format("its format is {}", version));
    }
    if (is_binary == 1) {
      in_.end_line();
      in_.set_binary();
      if (in_.number<int>() != 1 || size != 8) {
        in_.fail("its binary numbers are those of another kind of machine");
      }
    }
    require_word("$EndMeshFormat");
  }

  void require_word(std::string_view wanted) {
    if (in_.word() != wanted) {
      in_.fail(fmt::format("{} should stand here", wanted));
    }
  }

  void read_names() {
    for (auto left = in_.text_number<std::size_t>(); left > 0; --left) {
      const auto dimension = in_.text_number<int>(), group = in_.text_number<int>();
      found_.group_names[{dimension, group}] = in_.quoted();
    }
  }

  void read_entities() {
    std::array<std::size_t, 4> counts{};
    std::ranges::generate(counts, [&] { return in_.number<std::size_t>(); });
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (auto left = counts[index(dimension)]; left > 0; --left) {
        std::set<int>& groups = groups_[{dimension, in_.number<int>()}];
        in_.skip<double>(dimension == 0 ? 3 : 6);  // where it is, or its box
        for (auto more = in_.number<std::size_t>(); more > 0; --more) {
          groups.insert(group());
        }
        if (dimension > 0) {
          in_.skip<int>(in_.number<std::size_t>());  // what bounds it
        }
      }
    }
  }

  void read_node(std::size_t tag) {
    Vec3 at{};
    std::ranges::generate(at, [&] { return in_.number<double>(); });
    const auto [node, is_new] = found_.nodes.try_emplace(tag, at);
    if (!is_new && node->second != at) {
      in_.fail(fmt::format("node {} is given twice, at two places", tag));
    }
  }

  void read_nodes_2(bool have_parameters) {
    for (std::size_t left = count_2(); left > 0; --left) {
      read_node(tag_2());
      if (have_parameters) {
        const auto dimension = in_.number<int>();
        in_.skip<int>(1);  // the entity
        in_.skip<double>(dimension == 1 || dimension == 2 ? index(dimension) : 0);
      }
    }
  }

  void read_nodes_4() {
    const auto blocks = in_.number<std::size_t>();
    in_.skip<std::size_t>(3);  // their number, the first and last tag
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto dimension = in_.number<int>();
      in_.skip<int>(1);  // the entity
      const bool have_parameters = in_.number<int>() != 0;
      std::vector<std::size_t> tags;
      for (auto left = in_.number<std::size_t>(); left > 0; --left) {
        tags.push_back(in_.number<std::size_t>());
      }
      for (const std::size_t tag : tags) {
        read_node(tag);
        in_.skip<double>(have_parameters ? index(dimension) : 0);
      }
    }
  }

  void read_elements_2() {
    for (std::size_t left = count_2(); left > 0;) {
      if (in_.binary()) {  // one head for several elements
        const auto type = in_.number<int>();
        const std::size_t many = tag_2();
        const auto tags = in_.number<int>();
        for (std::size_t i = 0; i < many; ++i) {
          tag_2();
          read_element_2(type, tags);
        }
        left -= std::min(left, many);
      } else {
        tag_2();
        const auto type = in_.number<int>(), tags = in_.number<int>();
        read_element_2(type, tags);
        --left;
      }
    }
  }

  void read_element_2(int type, int tags) {
    const ElementKind kind = kind_of(type);
    const int member_of = tags > 0 ? group() : 0;
    const int entity = tags > 1 ? in_.number<int>() : 0;
    in_.skip<int>(tags > 2 ? index(tags - 2) : 0);  // partitions
    auto& nodes = found_.parts[{kind.dimension, entity, member_of, type}];
    for (int n = 0; n < kind.nodes; ++n) {
      nodes.push_back(tag_2());
    }
  }

  void read_elements_4() {
    const auto blocks = in_.number<std::size_t>();
    in_.skip<std::size_t>(3);  // elements in all, the first and last tag
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto dimension = in_.number<int>(), entity = in_.number<int>(),
                 type = in_.number<int>();
      const ElementKind kind = kind_of(type);
      if (kind.dimension != dimension) {
        in_.fail(fmt::format("elements of type {} on an entity of dimension {}", type, dimension));
      }
      std::vector<std::size_t> nodes;
      for (auto left = in_.number<std::size_t>(); left > 0; --left) {
        in_.skip<std::size_t>(1);
        for (int n = 0; n < kind.nodes; ++n) {
          nodes.push_back(in_.number<std::size_t>());
        }
      }
      std::set<int>& groups = groups_[{dimension, entity}];
      if (groups.empty()) {
        groups.insert(0);
      }
      for (const int one : groups) {
        auto& all = found_.parts[{dimension, entity, one, type}];
        all.insert(all.end(), nodes.begin(), nodes.end());
      }
    }
  }

  /// How many follow: always text, the last of its line before bytes.
  std::size_t count_2() {
    const auto count = in_.text_number<std::size_t>();
    if (in_.binary()) {
      in_.end_line();
    }
    return count;
  }

  std::size_t tag_2() { return index(in_.number<int>()); }

  /// Without its sign.
  int group() { return static_cast<int>(std::abs(long{in_.number<int>()})); }

  /// Of Gmsh's number of a linear element.
  ElementKind kind_of(int type) {
    switch (type) {
      case 1:
        return {1, 2};
      case 2:
        return {2, 3};
      case 3:
        return {2, 4};
      case 4:
        return {3, 4};
      case 5:
        return {3, 8};
      case 6:
        return {3, 6};
      case 7:
        return {3, 5};
      case 15:
        return {0, 1};
      default:
        in_.fail(fmt::format(
            "elements of Gmsh type {}; only linear ones are read (mesh it with order 1)", type));
    }
  }

  Scanner in_;
  MshFile found_;
  bool is_4_ = false;
  std::map<std::pair<int, int>, std::set<int>> groups_;  // 4.1: by dimension and entity
};

}  // namespace

MshFile read_msh_file(const fs::path& file) {
  return Parser(file).read();
}

}  // namespace sanatrix::io

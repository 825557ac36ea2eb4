// The archive's bytes: magic, version, entries, and the SHA-256 of all of that at the end.
#include "core/archive.hpp"

#include <bit>
#include <cstring>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix {
namespace {

static_assert(std::endian::native == std::endian::little, "archives are little-endian");

constexpr std::string_view magic = "SANATRIX-ARCHIVE";
constexpr std::uint64_t version = 1;
constexpr std::size_t checksum_size = 64;

class Writer {
 public:
  void number(std::uint64_t value) { bytes(&value, sizeof value); }
  void text(std::string_view value) {
    number(value.size());
    bytes(value.data(), value.size());
  }
  template <class Map>
  void entries(const Map& map) {
    number(map.size());
    for (const auto& [name, values] : map) {
      text(name);
      number(values.size());
      bytes(values.data(), values.size() * sizeof(values[0]));
    }
  }
  void bytes(const void* data, std::size_t size) {
    if (size > 0) {
      out.append(static_cast<const char*>(data), size);
    }
  }
  std::string out;
};

class Reader {
 public:
  Reader(std::string_view rest, const std::filesystem::path& file) : rest_(rest), file_(file) {}
  std::uint64_t number() {
    std::uint64_t value = 0;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view take(std::size_t size) {
    require(size <= rest_.size(), "{} is damaged: it ends within an entry", file_.string());
    const std::string_view part = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return part;
  }
  template <class Map>
  void entries(Map& map) {
    using Values = typename Map::mapped_type;
    constexpr std::size_t item = sizeof(typename Values::value_type);
    for (std::uint64_t left = number(); left > 0; --left) {
      const std::string name(take(number()));
      const std::uint64_t count = number();
      require(count <= rest_.size() / item, "{} is damaged: entry '{}' is too long", file_.string(),
              name);
      const std::string_view data = take(count * item);
      Values& values = map[name];
      values.resize(count);
      if (count > 0) {
        std::memcpy(values.data(), data.data(), data.size());
      }
    }
  }

 private:
  std::string_view rest_;
  const std::filesystem::path& file_;
};

template <class Map>
const typename Map::mapped_type& entry(const Map& map, const std::string& name, const char* kind) {
  const auto found = map.find(name);
  if (found == map.end()) {
    throw Error(Fault::Input, fmt::format("archive holds no {} '{}'", kind, name),
                "it was written by another version of this program; run the stage again");
  }
  return found->second;
}

}  // namespace

void Archive::save(const std::filesystem::path& file) const {
  Writer writer;
  writer.bytes(magic.data(), magic.size());
  writer.number(version);
  writer.entries(reals);
  writer.entries(integers);
  writer.entries(texts);
  writer.out += sha256_of_text(writer.out);
  write_text(file, writer.out);
}

Archive Archive::load(const std::filesystem::path& file) {
  const std::string all = read_text(file);
  const char* hint = "delete it and run the stage that writes it again";
  if (all.size() < magic.size() + checksum_size || !std::string_view(all).starts_with(magic)) {
    throw Error(Fault::Input, fmt::format("{} is not an archive of Sanatrix", file.string()), hint);
  }
  const std::string_view body = std::string_view(all).substr(0, all.size() - checksum_size);
  if (sha256_of_text(body) != std::string_view(all).substr(body.size())) {
    throw Error(Fault::Input,
                fmt::format("{} is damaged: its checksum does not match", file.string()), hint);
  }
  Reader reader(body.substr(magic.size()), file);
  const std::uint64_t found = reader.number();
  require(found == version, "{} has archive version {}, this program reads version {}",
          file.string(), found, version);
  Archive archive;
  reader.entries(archive.reals);
  reader.entries(archive.integers);
  reader.entries(archive.texts);
  return archive;
}

const std::vector<double>& Archive::real(const std::string& name) const {
  return entry(reals, name, "numbers");
}

const std::vector<std::int64_t>& Archive::integer(const std::string& name) const {
  return entry(integers, name, "integers");
}

}  // namespace sanatrix

#include "io/archive.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <memory>

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <unistd.h>

#include "core/confined_child.hpp"
#include "core/error.hpp"

namespace sanatrix::io {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t small_enough = 16U << 20U;  // a ratio below this harms nobody
constexpr std::size_t longest_name = 512;

struct Close {
  void operator()(archive* a) const { archive_read_free(a); }
};
using Reader = std::unique_ptr<archive, Close>;

/// A plain relative path of plain parts, in any system's eyes.
bool stays_inside(const std::string& name) {
  if (name.empty() || name.size() > longest_name || name.front() == '/' ||
      std::ranges::any_of(name, [](unsigned char c) { return c < 32 || c == '\\' || c == ':'; })) {
    return false;
  }
  const fs::path path(name);
  return std::ranges::none_of(path, [](const fs::path& part) { return part == ".."; });
}

/// What macOS puts beside every file.
bool is_clutter(const std::string& name) {
  return name.starts_with("__MACOSX/") || name.ends_with(".DS_Store");
}

/// Writes one entry's bytes; `total` grows with what really comes out, whatever the entry claims.
class Unpacker {
 public:
  Unpacker(const fs::path& file, fs::path folder, const ArchiveLimits& limits)
      : reader_(archive_read_new()),
        folder_(std::move(folder)),
        limits_(limits),
        packed_(fs::file_size(file)) {
    archive_read_support_format_zip_seekable(reader_.get());
    constexpr std::size_t block = 1U << 16U;
    if (archive_read_open_filename(reader_.get(), file.c_str(), block) != ARCHIVE_OK) {
      damaged();
    }
  }

  /// Everything that can be known without unpacking, so that nothing is written of a bad archive.
  void check() {
    while (archive_entry* entry = next()) {
      vet(entry);
    }
  }
  /// Files written.
  std::uint64_t run() {
    while (archive_entry* entry = next()) {
      vet(entry);
      take(entry);
    }
    return files_;
  }

 private:
  [[noreturn]] void damaged() const {
    throw Error(Fault::Input,
                fmt::format("the archive cannot be read{}",
                            number_ > 0 ? fmt::format(" (entry {})", number_) : std::string()),
                "make the zip file again from the original files");
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(Fault::Input, fmt::format("the archive is refused: entry {} {}", number_, why),
                "make the zip file again from the original files");
  }

  /// Nothing at the end.
  archive_entry* next() {
    archive_entry* entry = nullptr;
    const int state = archive_read_next_header(reader_.get(), &entry);
    if (state == ARCHIVE_EOF) {
      return nullptr;
    }
    if (state != ARCHIVE_OK && state != ARCHIVE_WARN) {
      damaged();
    }
    ++number_;
    if (number_ > limits_.entries) {
      throw Error(Fault::Resource,
                  fmt::format("the archive has more than {} entries", limits_.entries),
                  "pack one examination only");
    }
    return entry;
  }

  static std::string name_of(archive_entry* entry) {
    const char* text = archive_entry_pathname(entry);
    return text == nullptr ? "" : text;
  }

  void vet(archive_entry* entry) const {
    if (!stays_inside(name_of(entry))) {
      refuse("has a name that leads out of the folder");
    }
    if (archive_entry_hardlink(entry) != nullptr || archive_entry_symlink(entry) != nullptr ||
        (archive_entry_filetype(entry) != AE_IFREG && archive_entry_filetype(entry) != AE_IFDIR)) {
      refuse("is a link or a device, not a file");
    }
    if (archive_entry_is_encrypted(entry) != 0) {
      refuse("is locked with a password");
    }
  }

  void take(archive_entry* entry) {
    const std::string name = name_of(entry);
    if (archive_entry_filetype(entry) == AE_IFDIR || is_clutter(name)) {
      return;
    }
    const fs::path target = folder_ / name;
    std::error_code problem;
    fs::create_directories(target.parent_path(), problem);
    const int file =
        ::open(target.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (problem || file < 0) {
      refuse("has a name that cannot be used, or that was there before");
    }
    const std::unique_ptr<const int, void (*)(const int*)> closing(
        &file, [](const int* f) { ::close(*f); });
    copy(file);
    ++files_;
  }

  void copy(int to) {
    std::array<char, 1U << 16U> piece{};
    for (;;) {
      const la_ssize_t size = archive_read_data(reader_.get(), piece.data(), piece.size());
      if (size < 0) {
        damaged();
      }
      if (size == 0) {
        return;
      }
      bytes_ += static_cast<std::uint64_t>(size);
      if (bytes_ > limits_.bytes ||
          (bytes_ > small_enough && bytes_ / std::max<std::uint64_t>(packed_, 1) > limits_.ratio)) {
        throw Error(Fault::Resource,
                    fmt::format("the archive is refused: it unpacks to more than {} MB or {} times "
                                "its size",
                                limits_.bytes >> 20U, limits_.ratio),
                    "an examination is far smaller; make the zip file again");
      }
      for (la_ssize_t done = 0; done < size;) {
        const ssize_t written =
            ::write(to, piece.data() + done, static_cast<std::size_t>(size - done));
        if (written < 0 && errno != EINTR) {
          throw Error(Fault::Resource, "the archive cannot be unpacked: the disk is full",
                      "free some space");
        }
        done += std::max<ssize_t>(written, 0);
      }
    }
  }

  Reader reader_;
  fs::path folder_;
  ArchiveLimits limits_;
  std::uint64_t packed_, bytes_ = 0, number_ = 0, files_ = 0;
};

}  // namespace

bool is_zip(const fs::path& file) {
  std::array<char, 4> start{};
  std::error_code none;
  return fs::is_regular_file(file, none) &&
         std::ifstream(file, std::ios::binary).read(start.data(), start.size()) &&
         start == std::array<char, 4>{'P', 'K', 3, 4};
}

void unpack_zip(const fs::path& archive, const fs::path& folder, const ArchiveLimits& limits) {
  require(fs::create_directory(folder), "the folder to unpack into exists already");
  try {
    const ChildLimits child{.memory_bytes = std::uint64_t{256} << 20U,
                            .seconds = 600,
                            .answer_bytes = 4096,
                            .file_bytes = limits.bytes};
    const std::string files = in_confined_child("zip archive", child, [&] {
      Unpacker(archive, folder, limits).check();
      return std::to_string(Unpacker(archive, folder, limits).run());
    });
    require(files != "0", "the archive holds no files");
  } catch (...) {
    std::error_code none;
    fs::remove_all(folder, none);
    throw;
  }
}

}  // namespace sanatrix::io

// Complete-or-absent files on POSIX: a temporary neighbour, fsync, rename, fsync of the folder.
#include "core/files.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include "core/error.hpp"

namespace sanatrix {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const char* activity, int code) {
  throw Error(Fault::Resource,
              fmt::format("cannot {} {}: {}", activity, file.string(), std::strerror(code)),
              code == ENOSPC || code == EDQUOT ? "free some disk space and run again"
                                               : "check that the folder exists and may be written");
}

/// Owns a POSIX file descriptor.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : value_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (value_ >= 0) {
      ::close(value_);
    }
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return value_; }

 private:
  int value_;
};

/// Hidden name in the same folder, so that the rename stays on one file system. The whole old name
/// is kept at the end because writers choose their format by it (".nii.gz").
fs::path aside_name(const fs::path& file) {
  static std::atomic<unsigned> count{0};
  return file.parent_path() /
         fmt::format(".aside-{}-{}-{}", ::getpid(), count++, file.filename().string());
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Removes the temporary file unless it has been renamed.
class Aside {
 public:
  explicit Aside(fs::path path) : path_(std::move(path)) {}
  ~Aside() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    ensure(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1,
           "SHA-256 is not available in OpenSSL");
  }
  void add(const char* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  std::string hexadecimal() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    std::string text;
    for (unsigned i = 0; i < size; ++i) {
      text += fmt::format("{:02x}", digest[i]);
    }
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

void require_readable(bool ok, const fs::path& file) {
  if (!ok) {
    const int code = errno;
    throw Error(Fault::Input, fmt::format("cannot read {}: {}", file.string(), std::strerror(code)),
                "check the path");
  }
}

}  // namespace

std::string read_text(const fs::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  std::string text;
  if (in && !fs::is_directory(file)) {
    in.seekg(0, std::ios::end);
    text.resize(static_cast<std::size_t>(std::max<std::streamoff>(in.tellg(), 0)));
    in.seekg(0);
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
  } else if (errno == 0) {
    errno = EISDIR;
  }
  require_readable(in.good() && errno != EISDIR, file);
  return text;
}

void sync_to_disk(const fs::path& path) {
  const Descriptor descriptor(path, O_RDONLY);
  // Some file systems cannot flush folders and say EINVAL; that is no loss of the data.
  if (descriptor.get() < 0 || (::fsync(descriptor.get()) != 0 && errno != EINVAL)) {
    fail(path, "flush", errno);
  }
}

void write_aside(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  const Aside aside(aside_name(file));
  write(aside.path());
  if (!fs::exists(aside.path())) {
    fail(file, "write", ENOENT);
  }
  sync_to_disk(aside.path());
  std::error_code code;
  fs::rename(aside.path(), file, code);
  if (code) {
    fail(file, "write", code.value());
  }
  sync_to_disk(folder_of(file));
}

void write_text(const fs::path& file, std::string_view text) {
  write_aside(file, [&](const fs::path& aside) {
    const Descriptor descriptor(aside, O_WRONLY | O_CREAT | O_TRUNC);
    if (descriptor.get() < 0) {
      fail(file, "write", errno);
    }
    while (!text.empty()) {
      const ssize_t written = ::write(descriptor.get(), text.data(), text.size());
      if (written < 0 && errno != EINTR) {
        fail(file, "write", errno);
      }
      text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
  });
}

std::string sha256_of_file(const fs::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  require_readable(in.good(), file);
  Sha256 sum;
  std::vector<char> block(std::size_t{1} << 20);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0) {
    sum.add(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  require_readable(!in.bad(), file);
  return sum.hexadecimal();
}

std::string sha256_of_text(std::string_view text) {
  Sha256 sum;
  sum.add(text.data(), text.size());
  return sum.hexadecimal();
}

}  // namespace sanatrix

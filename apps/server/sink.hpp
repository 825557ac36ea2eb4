// Where the body of a request goes.
#pragma once

#include <cerrno>
#include <filesystem>
#include <optional>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace sanatrix::server {

/// The body of a request as it comes in: to memory, or to a new file.
class Sink {
 public:
  Sink(const std::optional<std::filesystem::path>& target, std::string& memory) : memory_(memory) {
    if (target) {
      file_ = ::open(target->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
      failed_ = file_ < 0;
    }
  }
  ~Sink() {
    if (file_ >= 0) {
      ::close(file_);
    }
  }
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;

  void add(const char* data, std::size_t size) {
    if (file_ < 0) {
      memory_.append(data, size);
      return;
    }
    while (size > 0 && !failed_) {
      const ssize_t written = ::write(file_, data, size);
      if (written > 0) {
        data += written;
        size -= static_cast<std::size_t>(written);
      } else if (errno != EINTR) {
        failed_ = true;  // disk full
      }
    }
  }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  std::string& memory_;
  int file_ = -1;
  bool failed_ = false;
};

}  // namespace sanatrix::server

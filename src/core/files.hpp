// Files that are either complete or absent: written aside, flushed to disk, renamed. And SHA-256.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace sanatrix {

/// Whole file as text; Error{Input} naming the file when it cannot be read.
std::string read_text(const std::filesystem::path& file);
/// Error{Resource} naming the file and the cause (disk full) when it cannot be written completely.
void write_text(const std::filesystem::path& file, std::string_view text);
/// Calls `write` with a temporary name beside `file` (same extension), then fsyncs and renames.
void write_aside(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write);
/// Flushes a file or folder to disk.
void sync_to_disk(const std::filesystem::path& path);
/// Lower-case hexadecimal SHA-256.
std::string sha256_of_file(const std::filesystem::path& file);
std::string sha256_of_text(std::string_view text);

}  // namespace sanatrix

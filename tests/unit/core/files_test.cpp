// Files are complete or absent, and the archive gives back every bit or says that it is damaged.
#include "core/files.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "core/archive.hpp"
#include "core/error.hpp"
#include "own_folder.hpp"

namespace sanatrix {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Files : public ::testing::Test {
 protected:
  ~Files() override { fs::remove_all(folder_); }
  [[nodiscard]] std::size_t file_count() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_ = testing::own_folder();
};

template <class F>
Error error_of(F&& work) {
  try {
    work();
  } catch (const Error& e) {
    return e;
  }
  return Error(Fault::Internal, "nothing was thrown");
}

TEST_F(Files, WrittenTextComesBackAndReplacesTheOldOne) {
  const fs::path file = folder_ / "a.json";
  const std::string text = std::string("line\n\0end", 9);
  write_text(file, "something longer that was there before");
  write_text(file, text);
  EXPECT_EQ(read_text(file), text);
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(Files, Sha256OfTheStandardsExample) {  // FIPS 180-2, appendix B.1
  const char* expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  EXPECT_EQ(sha256_of_text("abc"), expected);
  write_text(folder_ / "abc", "abc");
  EXPECT_EQ(sha256_of_file(folder_ / "abc"), expected);
}

TEST_F(Files, AFailedWriterLeavesTheOldFileAndNothingElse) {
  const fs::path file = folder_ / "mesh.vtu";
  write_text(file, "old");
  EXPECT_THROW(write_aside(file,
                           [&](const fs::path& aside) {
                             EXPECT_EQ(aside.extension(), ".vtu");
                             std::ofstream(aside) << "half";
                             throw std::runtime_error("stopped");
                           }),
               std::runtime_error);
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(Files, AnUnwritableFolderIsAResourceErrorThatNamesTheFile) {
  const fs::path file = folder_ / "absent" / "a.txt";
  const Error e = error_of([&] { write_text(file, "x"); });
  EXPECT_EQ(e.fault(), Fault::Resource);
  EXPECT_THAT(e.what(), HasSubstr(file.string()));
}

TEST_F(Files, AFileThatDoesNotFitIsAResourceErrorAndLeavesNothing) {
  // A limit on the size of files stands in for a full disk.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Error e = error_of([&] { write_text(folder_ / "big.bin", std::string(200000, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(e.fault(), Fault::Resource);
  EXPECT_THAT(e.what(), HasSubstr("big.bin"));
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(Files, AMissingFileOrAFolderIsAnInputErrorThatNamesIt) {
  for (const fs::path& file : {folder_ / "absent.txt", folder_}) {
    const Error e = error_of([&] { read_text(file); });
    EXPECT_EQ(e.fault(), Fault::Input);
    EXPECT_THAT(e.what(), HasSubstr(file.string()));
  }
}

TEST_F(Files, ArchiveKeepsEveryBit) {
  Archive archive;
  archive.reals["x"] = {0.1, -0.0, std::numeric_limits<double>::denorm_min(), 1e308};
  archive.reals["empty"] = {};
  archive.integers["n"] = {std::numeric_limits<std::int64_t>::min(), 7};
  archive.texts["why"] = "because";
  archive.save(folder_ / "a.bin");
  const Archive back = Archive::load(folder_ / "a.bin");
  EXPECT_EQ(back.reals, archive.reals);
  EXPECT_TRUE(std::signbit(back.real("x")[1]));
  EXPECT_EQ(back.integers, archive.integers);
  EXPECT_EQ(back.texts, archive.texts);
  EXPECT_THAT(error_of([&] { (void)back.real("absent"); }).what(), HasSubstr("absent"));
}

TEST_F(Files, ATruncatedOrChangedArchiveIsRefused) {
  Archive archive;
  archive.reals["x"] = std::vector<double>(1000, 1.0);
  const fs::path file = folder_ / "a.bin";
  archive.save(file);
  const std::string good = read_text(file);
  std::string changed = good;
  changed[good.size() / 2] ^= 1;
  for (const std::string& bad :
       {changed, good.substr(0, good.size() - 1), good.substr(0, 20), std::string()}) {
    write_text(file, bad);
    const Error e = error_of([&] { Archive::load(file); });
    EXPECT_EQ(e.fault(), Fault::Input);
    EXPECT_THAT(e.what(), HasSubstr(file.string()));
  }
}

TEST(ErrorText, IsOneLineWithTheTrailOutermostFirst) {
  const Error e = error_of([] {
    during("unload", [] { during("gravity 40 %", [] { require(false, "cell {} is\nflat", 3); }); });
  });
  EXPECT_EQ(e.one_line(), "unload: gravity 40 %: cell 3 is flat");
}

}  // namespace
}  // namespace sanatrix

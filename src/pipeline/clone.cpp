#include "pipeline/clone.hpp"

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;

void link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code problem;
  fs::create_hard_link(from, to, problem);
  if (problem) {
    fs::copy_file(from, to);
  }
}

void link_tree(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path target = to / entry.path().lexically_relative(from);
    if (entry.is_directory()) {
      fs::create_directories(target);
    } else if (entry.is_regular_file()) {
      link_or_copy(entry.path(), target);
    }
  }
}

}  // namespace

Case clone_case(const Case& from, const fs::path& folder, Stage last) {
  const fs::path aside = folder.parent_path() / fmt::format(".{}.new", folder.filename().string());
  Case copy = from;
  copy.folder = aside;
  try {
    fs::remove_all(aside);
    fs::create_directories(aside / "inputs");
    for (auto& [name, input] : copy.inputs) {
      const fs::path source = from.folder / input.file;
      if (fs::path(input.file).is_absolute()) {  // from outside; its own name may name a person
        input.file =
            fmt::format("inputs/{}-{:.8}{}", name, input.sha256, source.extension().string());
      }
      link_or_copy(source, aside / input.file);
    }
    for (const StageInfo& stage : all_stages()) {
      if (stage.id <= last && fs::exists(from.stage_folder(stage.id))) {
        link_tree(from.stage_folder(stage.id), copy.stage_folder(stage.id));
      }
    }
    save_case(copy);
    fs::rename(aside, folder);
  } catch (const fs::filesystem_error& e) {
    throw Error(Fault::Resource,
                fmt::format("{}: the copy of the case cannot be made: {}",
                            folder.filename().string(), e.code().message()),
                "check free space and permissions");
  }
  copy.folder = folder;
  return copy;
}

}  // namespace sanatrix::pipeline

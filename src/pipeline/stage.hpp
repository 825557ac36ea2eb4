// The nine steps of the pipeline: their names, folders, order and what each depends on.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace sanatrix::pipeline {

enum class Stage { Image, Segment, Mesh, Unload, Supine, Surgery, Heal, Upright, Outcome };

struct StageInfo {
  Stage id;
  std::string name;                   ///< on the command line: "heal"
  std::string folder;                 ///< under stages/: "70-heal"
  std::string letter;                 ///< step of the paper's Fig 1
  std::string title;                  ///< for people
  int version;                        ///< raise it when the stage computes something else
  std::vector<Stage> upstream;        ///< whose artefacts it reads
  std::vector<std::string> prefixes;  ///< of the parameters it reads
  bool collective;                    ///< every MPI rank takes part (solver calls)
};

/// In running order.
const std::array<StageInfo, 9>& all_stages();
const StageInfo& info(Stage stage);
/// Error{Usage} listing the stages when there is no such name.
Stage parse_stage(const std::string& name);

}  // namespace sanatrix::pipeline

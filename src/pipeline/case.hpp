// The case folder: the patient's inputs, the chosen parameters and the stages' results. The folder
// is the database; case.json is its head (docs/user/case-folder.md).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "pipeline/focus.hpp"
#include "pipeline/parameters.hpp"
#include "pipeline/stage.hpp"

namespace sanatrix::pipeline {

struct InputFile {
  std::string file;    ///< relative to the case folder
  std::string sha256;  ///< of its content
};

struct Case {
  std::filesystem::path folder;
  std::string pseudonym;  ///< made from the first input's hash; no name of anybody
  std::string label_preset = "sanatrix";
  std::map<std::string, InputFile> inputs;  ///< "labels", "image", perhaps "plan", "scan", ...
  Parameters parameters;
  std::optional<FocusRule> focus;  ///< where the mesh is fine; follows the plan lazily

  [[nodiscard]] bool has_plan() const { return inputs.contains("plan"); }
  /// Nothing but a surface scan is known: the geometry was captured standing, not prone.
  [[nodiscard]] bool scan_only() const {
    return !inputs.contains("labels") && !inputs.contains("image");
  }
  [[nodiscard]] std::filesystem::path input(const std::string& name) const;
  [[nodiscard]] std::filesystem::path stage_folder(Stage stage) const;
  /// The plan as read, with the surgery.* parameters applied. Error{Input} when there is none.
  [[nodiscard]] surgery::Plan plan() const;
};

/// Error{Input} when there is no case.json or it cannot be used.
Case open_case(const std::filesystem::path& folder);
void save_case(const Case& patient);

/// Moves the mesh focus when the plan has left it.
void follow_plan(Case& patient);
/// Error{Input} when a file in inputs/ is not what was given.
void check_inputs(const Case& patient);

/// The text with the case's place on this machine left out, for logs that travel with the case.
std::string without_place(const Case& patient, std::string text);

/// While it lives, no other process may work on the case. Freed by the kernel when we die.
class CaseLock {
 public:
  /// Error{Resource} naming the process that holds it.
  explicit CaseLock(const std::filesystem::path& folder);
  ~CaseLock();
  CaseLock(const CaseLock&) = delete;
  CaseLock& operator=(const CaseLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace sanatrix::pipeline

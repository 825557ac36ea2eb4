// Cases on disk: what makes a stage stale, and what survives a kill at any point of a replacement.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.hpp"
#include "own_folder.hpp"
#include "pipeline/stage_store.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ACase : public ::testing::Test {
 protected:
  ACase() {
    patient_.folder = testing::own_folder();
    patient_.pseudonym = "case-test";
    patient_.inputs["labels"] = {"inputs/labels.nii.gz", std::string(64, 'a')};
  }
  void finish(Stage stage, const std::string& content) {
    begin(patient_, stage);
    write(aside_folder(patient_, stage) / "result.txt", content);
    commit(patient_, stage,
           {.recipe = recipe(patient_, stage), .warnings = {}, .numbers = {}, .files = {}});
  }
  ~ACase() override { fs::remove_all(patient_.folder); }
  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  static std::string read(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  State state(Stage stage) { return status(patient_, stage).state; }

  Case patient_;
};

TEST_F(ACase, IsWrittenAndReadBackTheSame) {
  patient_.parameters.set("heal.days=30");
  patient_.inputs["plan"] = {"inputs/plan-0.json", std::string(64, 'b')};
  patient_.focus =
      FocusRule{Vec3{0.1, 1.0 / 3.0, -0.2}, Vec3{0, -1, 0}, surgery::Side::Right, 0.02};
  save_case(patient_);
  const Case read_back = open_case(patient_.folder);
  for (const StageInfo& stage : all_stages()) {
    EXPECT_EQ(recipe(read_back, stage.id).fingerprint(), recipe(patient_, stage.id).fingerprint());
  }
}

TEST_F(ACase, AFinishedStageIsFreshUntilWhatItDependsOnChanges) {
  finish(Stage::Image, "1");
  finish(Stage::Segment, "1");
  EXPECT_EQ(state(Stage::Segment), State::Fresh);
  EXPECT_EQ(state(Stage::Mesh), State::Missing);
  patient_.parameters.set("heal.days=30");
  EXPECT_EQ(state(Stage::Segment), State::Fresh);
  patient_.parameters.set("segment.spacing_mm=2");
  EXPECT_EQ(state(Stage::Image), State::Fresh);
  EXPECT_EQ(state(Stage::Segment), State::Stale);
  EXPECT_THAT(status(patient_, Stage::Segment).reason, HasSubstr("segment.spacing_mm: 1 -> 2"));
}

TEST_F(ACase, ALostFileMakesTheStageStale) {
  finish(Stage::Image, "1");
  fs::remove(patient_.stage_folder(Stage::Image) / "result.txt");
  EXPECT_EQ(state(Stage::Image), State::Stale);
}

TEST_F(ACase, AParameterReachesExactlyTheStagesDownstreamOfIt) {
  patient_.inputs["plan"] = {"inputs/plan.json", std::string(64, 'c')};
  const auto changed_by = [&](const std::string& assignment) {
    Case other = patient_;
    other.parameters.set(assignment);
    std::string names;
    for (const StageInfo& stage : all_stages()) {
      if (recipe(other, stage.id).fingerprint() != recipe(patient_, stage.id).fingerprint()) {
        names += stage.name + " ";
      }
    }
    return names;
  };
  EXPECT_EQ(changed_by("surgery.margin_mm=15"), "surgery heal upright outcome ");
  EXPECT_EQ(changed_by("heal.days=30"), "heal upright outcome ");
  EXPECT_EQ(changed_by("outcome.pictures=no"), "outcome ");
  EXPECT_EQ(changed_by("tissue.adipose_c1_pa=200"), "unload supine surgery heal upright outcome ");
}

TEST_F(ACase, AFailureIsRememberedAndTheLastGoodResultKept) {
  finish(Stage::Image, "good");
  patient_.inputs["labels"].sha256 = std::string(64, 'd');
  record_failure(patient_, Stage::Image, "image: broken");
  EXPECT_EQ(state(Stage::Image), State::Failed);
  EXPECT_EQ(status(patient_, Stage::Image).reason, "image: broken");
  EXPECT_EQ(read(patient_.stage_folder(Stage::Image) / "result.txt"), "good");
  finish(Stage::Image, "better");
  EXPECT_EQ(state(Stage::Image), State::Fresh);
}

TEST_F(ACase, AKillBetweenTheTwoRenamesIsRepaired) {
  finish(Stage::Image, "old");
  const fs::path result = patient_.stage_folder(Stage::Image);
  fs::rename(result, result.parent_path() / ".10-image.old");  // killed here
  clean_up(patient_);
  EXPECT_EQ(read(result / "result.txt"), "old");
}

TEST_F(ACase, LeftoversOfDeadRunsAreRemoved) {
  begin(patient_, Stage::Mesh);
  clean_up(patient_);
  EXPECT_FALSE(fs::exists(aside_folder(patient_, Stage::Mesh)));
}

TEST_F(ACase, ACheckpointIsKeptOnlyForWhatIsToBeComputed) {
  patient_.inputs["plan"] = {"inputs/plan.json", std::string(64, 'c')};
  begin(patient_, Stage::Heal);
  write(aside_folder(patient_, Stage::Heal) / "checkpoint.bin", "day 6");
  clean_up(patient_);
  EXPECT_TRUE(fs::exists(aside_folder(patient_, Stage::Heal) / "checkpoint.bin"));
  patient_.parameters.set("heal.days=30");
  clean_up(patient_);
  EXPECT_FALSE(fs::exists(aside_folder(patient_, Stage::Heal)));
}

TEST_F(ACase, ASecondProcessIsRefused) {
  const CaseLock lock(patient_.folder);
  const pid_t child = fork();
  if (child == 0) {
    int code = 0;
    try {
      const CaseLock second(patient_.folder);
    } catch (const Error& e) {
      code = e.one_line().find(std::to_string(getppid())) != std::string::npos ? 4 : 1;
    }
    _exit(code);
  }
  int exit_state = 0;
  waitpid(child, &exit_state, 0);
  EXPECT_EQ(WEXITSTATUS(exit_state), 4);
}

TEST_F(ACase, WithoutCaseJsonIsRefusedWithTheNextAction) {
  try {
    open_case(patient_.folder);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::Input);
    EXPECT_THAT(e.hint(), HasSubstr("sanatrix new"));
  }
}

}  // namespace
}  // namespace sanatrix::pipeline

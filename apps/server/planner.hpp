// The planner's API: what each address answers. docs/user/planner-api.json describes the same.
#pragma once

#include <functional>
#include <mutex>
#include <regex>

#include "case_store.hpp"
#include "guard.hpp"
#include "http.hpp"
#include "job_queue.hpp"

namespace sanatrix::server {

/// What the command line of this build can do beyond the basics; the page offers what is there.
struct Abilities {
  bool dicom = false, scan = false, scan_only = false, tumour = false, report = false;
};

class Planner final : public Handler {
 public:
  Planner(CaseStore& cases, JobQueue& jobs, const Abilities& abilities);
  /// The guard knows the port, which is known only when the server listens.
  void admit(const Guard& guard) { guard_ = &guard; }

  std::optional<Response> refuse(const Request& head) override;
  std::optional<std::filesystem::path> upload_target(const Request& head) override;
  Response answer(const Request& request) override;
  std::vector<std::pair<std::string, std::string>> common_headers() const override {
    return Guard::common_headers();
  }
  /// "GET /api/cases/{case}" and so on, in the words of OpenAPI.
  [[nodiscard]] std::vector<std::string> routes() const;

 private:
  /// Parts of the address that stand for {names}.
  using Parts = std::vector<std::string>;
  using Answer = Response (Planner::*)(const Request&, const Parts&);
  struct Route {
    std::string method, pattern;
    std::regex form;
    Answer answer;
  };
  void add(const std::string& method, const std::string& pattern, Answer reply);
  Response route(const Request& request);

  Response session(const Request& request, const Parts& parts);
  Response list_cases(const Request& request, const Parts& parts);
  Response create_case(const Request& request, const Parts& parts);
  Response show_case(const Request& request, const Parts& parts);
  Response delete_case(const Request& request, const Parts& parts);
  Response copy_case(const Request& request, const Parts& parts);
  Response run_case(const Request& request, const Parts& parts);
  Response scene(const Request& request, const Parts& parts);
  Response healing(const Request& request, const Parts& parts);
  Response volume(const Request& request, const Parts& parts);
  Response show_plan(const Request& request, const Parts& parts);
  Response preview_plan(const Request& request, const Parts& parts);
  Response photograph(const Request& request, const Parts& parts);
  Response name_plan(const Request& request, const Parts& parts);
  Response propose_incision(const Request& request, const Parts& parts);
  Response carry_point(const Request& request, const Parts& parts);
  Response list_files(const Request& request, const Parts& parts);
  Response send_file(const Request& request, const Parts& parts);
  Response list_jobs(const Request& request, const Parts& parts);
  Response cancel_job(const Request& request, const Parts& parts);
  Response resume_job(const Request& request, const Parts& parts);
  Response events(const Request& request, const Parts& parts);
  Response take_upload(const Request& request, const Parts& parts);
  Response list_series(const Request& request, const Parts& parts);

  [[nodiscard]] std::vector<Step> steps_of_new_case(const nlohmann::json& wish,
                                                    const std::string& id) const;
  [[nodiscard]] std::filesystem::path uploaded(const nlohmann::json& id) const;

  CaseStore& cases_;
  JobQueue& jobs_;
  Abilities abilities_;
  const Guard* guard_ = nullptr;
  std::vector<Route> routes_;
  std::mutex looking_;  ///< into uploaded images
};

}  // namespace sanatrix::server

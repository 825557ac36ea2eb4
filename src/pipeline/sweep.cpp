#include "pipeline/sweep.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/clone.hpp"
#include "pipeline/json_object.hpp"
#include "pipeline/runner.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A parameter's values: a list (grid), or an interval to sample from.
struct Axis {
  std::string key;
  std::vector<std::string> values;
  double low = 0.0, high = 0.0;
};

std::string as_text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::vector<Axis> read_axes(const json& parameters, bool sampled) {
  std::vector<Axis> axes;
  for (const auto& [key, given] : parameters.items()) {
    Axis axis{key, {}};
    if (given.is_array()) {
      require(!given.empty(), "parameters.{}: the list of values is empty", key);
      for (const json& value : given) {
        axis.values.push_back(as_text(value));
      }
    } else {
      require(sampled, "parameters.{}: a grid needs a list of values, [1, 2, 3]", key);
      const JsonObject interval(given, "parameters." + key);
      interval.allow({"from", "to"});
      axis.low = interval.number("from", -1e300, 1e300);
      axis.high = interval.number("to", -1e300, 1e300);
      require(axis.low < axis.high, "parameters.{}: \"from\" must be below \"to\"", key);
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

using Settings = std::map<std::string, std::string>;

std::vector<Settings> grid(const std::vector<Axis>& axes) {
  std::vector<Settings> all{{}};
  for (const Axis& axis : axes) {
    std::vector<Settings> next;
    for (const Settings& before : all) {
      for (const std::string& value : axis.values) {
        next.push_back(before);
        next.back()[axis.key] = value;
      }
    }
    all = std::move(next);
  }
  return all;
}

/// Every axis is cut into as many strata as there are samples; each stratum is used once (McKay,
/// Beckman and Conover 1979, doi:10.2307/1268522). The generator and the shuffle are our own words,
/// so that a seed means the same samples on every machine.
class LatinHypercube {
 public:
  LatinHypercube(std::size_t samples, std::uint64_t seed) : samples_(samples), random_(seed) {}

  /// Positions in (0, 1), one per sample.
  std::vector<double> axis() {
    std::vector<std::size_t> stratum(samples_);
    std::iota(stratum.begin(), stratum.end(), 0U);
    for (std::size_t i = samples_; i > 1; --i) {
      std::swap(stratum[i - 1],
                stratum[static_cast<std::size_t>(uniform() * static_cast<double>(i))]);
    }
    std::vector<double> at;
    for (const std::size_t s : stratum) {
      at.push_back((static_cast<double>(s) + uniform()) / static_cast<double>(samples_));
    }
    return at;
  }

 private:
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }
  std::size_t samples_;
  std::mt19937_64 random_;
};

std::vector<Settings> latin_hypercube(const std::vector<Axis>& axes, std::size_t samples,
                                      std::uint64_t seed) {
  LatinHypercube cube(samples, seed);
  std::vector<Settings> all(samples);
  for (const Axis& axis : axes) {
    const std::vector<double> at = cube.axis();
    for (std::size_t s = 0; s < samples; ++s) {
      if (axis.values.empty()) {
        all[s][axis.key] = fmt::format("{:.6g}", axis.low + at[s] * (axis.high - axis.low));
      } else {
        const auto i = static_cast<std::size_t>(at[s] * static_cast<double>(axis.values.size()));
        all[s][axis.key] = axis.values[i];
      }
    }
  }
  return all;
}

/// The case as the task wants it, in memory: the plan may lie outside the case's folder.
Case varied(const Case& base, const SweepTask& task) {
  Case patient = base;
  if (!task.plan.empty()) {
    patient.inputs["plan"] = {task.plan.string(), sha256_of_file(task.plan)};
    patient.parameters.reset("surgery.");
  }
  patient.parameters.set("outcome.pictures", "no");  // hundreds of them are looked at by nobody
  for (const auto& [key, value] : task.settings) {
    patient.parameters.set(key, value);
  }
  patient.parameters.check();
  follow_plan(patient);
  return patient;
}

std::string describe(const SweepTask& task) {
  std::string text = task.plan.empty() ? "" : "plan=" + task.plan.filename().string();
  for (const auto& [key, value] : task.settings) {
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", key, value);
  }
  return text;
}

json outcome_of(const Case& patient) {
  return json::parse(read_text(patient.stage_folder(Stage::Outcome) / "outcome.json"));
}

/// Runs the task's own case to its outcome.
json compute(const Sweep& sweep, const SweepTask& task, const fs::path& folder, Monitor& monitor,
             Team& team, std::stop_token stop) {
  const Case base = open_case(sweep.case_folder);
  if (team.leads() && !fs::exists(folder / "case.json")) {
    fs::remove_all(folder);  // what a dead worker left half made
    clone_case(varied(base, task), folder, Stage::Outcome);
  }
  team.share(0);
  const Case patient = open_case(folder);
  run_case(patient, {}, monitor, team, std::move(stop));
  return outcome_of(patient);
}

/// Held while a task is worked on; waits for another process that does.
class TaskLock {
 public:
  TaskLock(const fs::path& folder, const Context& ctx) {
    for (;;) {
      try {
        lock_.emplace(folder);
        return;
      } catch (const Error&) {
        ctx.detail(0.0, "waiting for another worker on this task");
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
      }
    }
  }

 private:
  std::optional<CaseLock> lock_;
};

void flatten(const json& value, const std::string& name, std::map<std::string, double>& columns) {
  if (value.is_number()) {
    columns[name] = value.get<double>();
  } else if (value.is_object()) {
    for (const auto& [key, inner] : value.items()) {
      flatten(inner, name.empty() ? key : fmt::format("{}.{}", name, key), columns);
    }
  }
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    out += c;
    if (c == '"') {
      out += c;
    }
  }
  out += '"';
  return out;
}

std::string csv(const Sweep& sweep, const json& rows) {
  std::set<std::string> names;
  std::vector<std::map<std::string, double>> columns;
  for (const json& row : rows) {
    columns.emplace_back();
    json outcome = row.value("outcome", json::object());
    outcome.erase("seconds");
    flatten(outcome, "", columns.back());
    for (const auto& [name, unused] : columns.back()) {
      names.insert(name);
    }
  }
  std::string text = "task,status,plan";
  for (const std::string& key : sweep.varied) {
    text += fmt::format(",{}", key);
  }
  for (const std::string& name : names) {
    text += fmt::format(",{}", name);
  }
  text += ",error\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const json& row = rows[r];
    text += fmt::format("{},{},{}", row["task"].get<std::string>(),
                        row["status"].get<std::string>(), quoted(row["plan"].get<std::string>()));
    for (const std::string& key : sweep.varied) {
      text += fmt::format(",{}", row["settings"].value(key, ""));
    }
    for (const std::string& name : names) {
      const auto value = columns[r].find(name);
      text += value == columns[r].end() ? "," : fmt::format(",{}", value->second);
    }
    text += fmt::format(",{}\n", quoted(row.value("error", "")));
  }
  return text;
}

std::vector<Settings> read_samples(const JsonObject& root, Sweep& sweep) {
  const std::string sampling =
      root.has("sampling") ? root.choice("sampling", {"grid", "latin_hypercube"}) : "grid";
  const bool sampled = sampling == "latin_hypercube";
  require(sampled == root.has("samples"),
          "samples: this key belongs to sampling \"latin_hypercube\", and only to it");
  std::vector<Axis> axes;
  if (root.has("parameters")) {
    axes = read_axes(root.object("parameters").raw(), sampled);
  }
  for (const Axis& axis : axes) {
    sweep.varied.push_back(axis.key);
  }
  if (!sampled) {
    return grid(axes);
  }
  require(!axes.empty(), "parameters: latin_hypercube needs at least one");
  return latin_hypercube(axes, static_cast<std::size_t>(root.number("samples", 1, 1e6)),
                         static_cast<std::uint64_t>(root.number_or("seed", 0, 1e15, 1)));
}

void read_into(const JsonObject& root, Sweep& sweep) {
  root.allow({"case", "plans", "parameters", "sampling", "samples", "seed"});
  const fs::path beside = sweep.file.parent_path();
  sweep.case_folder = fs::weakly_canonical(beside / root.text("case"));
  std::vector<fs::path> plans;
  if (root.has("plans")) {
    for (const std::string& name : root.texts("plans")) {
      plans.push_back(fs::weakly_canonical(beside / name));
      require(fs::exists(plans.back()), "plans: {} is not there", name);
    }
  }
  if (plans.empty()) {
    plans.emplace_back();
  }
  const std::vector<Settings> samples = read_samples(root, sweep);
  const Case base = open_case(sweep.case_folder);
  require(base.has_plan() || !plans.front().empty(),
          "the case has no surgical plan and \"plans\" names none");
  std::set<std::string> known;
  for (const fs::path& plan : plans) {
    for (const Settings& settings : samples) {
      SweepTask task = make_task(base, plan, settings);
      if (known.insert(task.key).second) {
        sweep.tasks.push_back(std::move(task));
      }
    }
  }
}

}  // namespace

SweepTask make_task(const Case& base, fs::path plan, Settings settings) {
  SweepTask task{"", std::move(plan), std::move(settings)};
  during(describe(task), [&] {
    task.key = recipe(varied(base, task), Stage::Outcome).fingerprint().substr(0, 32);
  });
  return task;
}

fs::path Sweep::result_file(const SweepTask& task) const {
  return out / "results" / (task.key + ".json");
}

bool Sweep::done(const SweepTask& task) const {
  return fs::exists(result_file(task));
}

Sweep read_sweep(const fs::path& file, const fs::path& out) {
  Sweep sweep;
  const std::string text = read_text(file);
  sweep.file = fs::weakly_canonical(file);
  sweep.out = out.empty() ? fs::path(sweep.file).replace_extension(".sweep") : fs::absolute(out);
  const json j = json::parse(text, nullptr, false);
  require(!j.is_discarded(), "{}: this is not JSON", file.filename().string());
  during(file.filename().string(), [&] { read_into(JsonObject(j, ""), sweep); });
  return sweep;
}

void run_task(const Sweep& sweep, const SweepTask& task, Monitor& monitor, Team& team,
              std::stop_token stop) {
  const fs::path place = sweep.out / "tasks" / task.key;
  std::optional<TaskLock> lock;
  if (team.leads()) {
    fs::create_directories(place);
    fs::create_directories(sweep.out / "results");
    lock.emplace(place, Context("sweep", monitor, stop));
  }
  if (team.share(sweep.done(task) ? 1 : 0) == 1) {
    return;
  }
  json result{{"task", task.key},
              {"plan", task.plan.empty() ? "" : task.plan.filename().string()},
              {"settings", task.settings}};
  try {
    result["outcome"] = compute(sweep, task, place / "case", monitor, team, std::move(stop));
    result["status"] = "ok";
  } catch (const Error& e) {
    if (e.fault() != Fault::Input && e.fault() != Fault::Numerics) {
      throw;
    }
    result["status"] = "failed";
    result["error"] = e.one_line();
  }
  if (team.leads()) {
    write_text(sweep.result_file(task), result.dump(2) + "\n");
    std::error_code ignored;  // a task's case is scratch
    fs::remove_all(place / "case", ignored);
  }
  team.share(0);
}

std::string collect(const Sweep& sweep) {
  json rows = json::array();
  for (const SweepTask& task : sweep.tasks) {
    rows.push_back(sweep.done(task) ? json::parse(read_text(sweep.result_file(task)))
                                    : json{{"task", task.key},
                                           {"plan", task.plan.filename().string()},
                                           {"settings", task.settings},
                                           {"status", "missing"}});
  }
  write_text(sweep.out / "results.csv", csv(sweep, rows));
  std::string text =
      json{{"sweep", sweep.file.filename().string()}, {"results", rows}}.dump(2) + "\n";
  write_text(sweep.out / "results.json", text);
  return text;
}

}  // namespace sanatrix::pipeline

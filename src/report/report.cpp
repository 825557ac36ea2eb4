#include "report/report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <unistd.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/glb_file.hpp"
#include "io/mesh_file.hpp"
#include "io/scan_file.hpp"
#include "report/external.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "report/views.hpp"

namespace sanatrix::report {
namespace {

namespace fs = std::filesystem;
using pipeline::Stage;

fs::path outcome_folder(const Findings& f) {
  return f.patient.stage_folder(Stage::Outcome);
}

std::string report_html(const Findings& f, const Program& program, const fs::path& pictures) {
  const fs::path outcome = outcome_folder(f);
  return page("Sanatrix report " + f.patient.pseudonym,
              fmt::format("<h1>Predicted outcome of breast-conserving surgery</h1><p "
                          "class=\"quiet\">{} &middot; patient's {} breast &middot; {}</p>{}",
                          escaped(f.patient.pseudonym), f.result.side() > 0 ? "LEFT" : "RIGHT",
                          escaped(program.version), notice()) +
                  plan_section(f, outcome) + views_section(f, pictures) + metrics_section(f) +
                  healing_section(f) + validation_section(f, pictures) + model_section(f, outcome) +
                  provenance_section(f, program) + limits_section());
}

/// The model's skin as files for other programs: with the patient's own skin only when asked.
void write_surfaces(const Findings& f, Photographs photographs, const fs::path& folder) {
  ClaySkin skin = clay_skin(f);
  if (photographs == Photographs::Yes && f.scans.preop &&
      f.scans.preop->placed.surface.has_photograph()) {
    skin.before = outcome::carry_texture(f.scans.preop->warp, f.scans.preop->placed.surface,
                                         f.skin.before.mesh);
    skin.after = skin.before;
    skin.after.mesh = f.skin.after;
  }
  io::write_glb(skin.before, {{"after surgery", skin.after.mesh.points}}, folder / "upright.glb");
  io::write_textured_obj(skin.before, folder / "upright_before.obj");
  io::write_textured_obj(skin.after, folder / "upright_after.obj");
  io::write_surface(skin.after.mesh, folder / "upright_after.stl");
  // Healing over the days, in the pose in which it was computed.
  std::vector<io::MorphTarget> days;
  const auto of_skin = [&](const pipeline::Frame& frame) {
    std::vector<Vec3> points;
    for (const int vertex : f.skin.before.vertex) {
      points.push_back(frame.points[static_cast<std::size_t>(vertex)]);
    }
    return points;
  };
  TexturedSurface supine = skin.before;
  supine.mesh.points = of_skin(f.result.frames.front());
  for (const pipeline::Frame& frame : f.result.frames) {
    if (frame.t_day > f.result.frames.front().t_day) {
      days.push_back({fmt::format("day {:g}", frame.t_day), of_skin(frame)});
    }
  }
  io::write_glb(supine, days, folder / "healing_supine.glb", 8.0);
}

std::optional<std::string> print_pdf(const fs::path& folder, const Context& ctx) {
  const fs::path profile = folder / ".browser";
  auto reason = run_external(
      "chromium",
      {"--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-extensions",
       "--disable-background-networking", "--user-data-dir=" + fs::absolute(profile).string(),
       "--no-pdf-header-footer", "--print-to-pdf=" + fs::absolute(folder / "report.pdf").string(),
       "file://" + fs::absolute(folder / "report.html").string()},
      90, ctx);
  fs::remove_all(profile);
  if (!reason && !fs::exists(folder / "report.pdf")) {
    return "chromium wrote no file";
  }
  return reason;
}

/// What is being made, until it is put in place: an interrupted report leaves nothing.
class Aside {
 public:
  explicit Aside(fs::path folder) : folder_(std::move(folder)) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Aside() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

void put_in_place(const fs::path& aside, const fs::path& final) {
  for (const auto& entry : fs::directory_iterator(aside)) {
    sync_to_disk(entry.path());
  }
  const fs::path retired = final.parent_path() / ".95-report.old";
  fs::remove_all(retired);
  if (fs::exists(final)) {
    fs::rename(final, retired);
  }
  fs::rename(aside, final);
  sync_to_disk(final.parent_path());
  fs::remove_all(retired);
}

}  // namespace

Written write_report(const pipeline::Case& patient, const Options& options, const Program& program,
                     const Context& ctx) {
  ctx.at(0.0, "reading the case");
  const Findings f = find(patient, ctx);
  const fs::path final = patient.folder / "stages" / "95-report";
  const Aside made(patient.folder / "stages" / ".95-report.new");
  const fs::path& aside = made.folder();
  Written written{final, {}, {}};
  const auto note = [&](const std::string& what, const std::optional<std::string>& reason) {
    if (reason) {
      written.notes.push_back("no " + what + ": " + *reason);
    }
  };
  ctx.at(0.2, "pictures");
  note("pictures", draw_views(f, aside, ctx));
  ctx.at(0.5, "surfaces");
  write_surfaces(f, options.in_files, aside);
  if (options.animations == Animations::Yes) {
    ctx.at(0.6, "animations");
    note("animations", draw_animations(f, aside, ctx.part(0.6, 0.8)));
  }
  ctx.at(0.8, "page");
  // Pictures are looked for beside the outcome's, so the page is written from the folder aside.
  write_text(aside / "report.html", report_html(f, program, aside));
  note("PDF", print_pdf(aside, ctx));
  put_in_place(aside, final);
  written.files.emplace_back("report.html");
  for (const auto& entry : fs::directory_iterator(final)) {
    if (entry.path().filename() != "report.html") {
      written.files.push_back(entry.path().filename());
    }
  }
  std::sort(written.files.begin() + 1, written.files.end());
  return written;
}

}  // namespace sanatrix::report
